"""Datasets on their way to others, and back: bundles, archives, registry, mirrors, loading, CSV."""
