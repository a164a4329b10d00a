"""Ground-truth datasets: cases, certified generation, Parquet, manifests, verification."""
