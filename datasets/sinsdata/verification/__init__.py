"""What a dataset on disk must satisfy, and how that is checked."""
