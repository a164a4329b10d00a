"""Navigation algorithms under test: float64, and no code shared with truth."""
