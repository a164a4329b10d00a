"""Scores: errors against truth, orders, floors and cost of the subjects."""
