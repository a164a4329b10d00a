"""Subjects that are no Python functions: programs in any language, and results that were computed beforehand."""
