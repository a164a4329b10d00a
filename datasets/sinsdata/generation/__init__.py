"""From a specification to a dataset: shards, workers, destinations."""
