"""The report: results of the other commands as one self-contained page, and as figures for papers."""
