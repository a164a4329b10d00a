"""From the formulas of the reference to certified tables, and to cases in memory."""
