"""Subjects, scores, claims and reports of the sinsbench benchmark."""

__version__ = "0.2.0"
