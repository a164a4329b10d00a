"""Subjects, scores, claims and reports of the sinsbench benchmark."""

__version__ = "0.1.0"
