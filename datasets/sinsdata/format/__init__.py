"""What a dataset on disk is made of: columns, units, hashes, manifest, names of files."""
