"""Stored benchmark runs: what is kept of one, and what has become slower since."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sinsbench.dashboard.comparison import COMPARISON_FIELDS, VERDICTS, compared, standing_regressions
    from sinsbench.dashboard.runs import Run, StoreError, Timing, is_run, read_runs

__all__ = [
    "COMPARISON_FIELDS", "VERDICTS", "Run", "StoreError", "Timing", "compared", "is_run", "read_runs",
    "standing_regressions",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Import what is asked for: the command line imports this package before it knows what to do."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from sinsbench.dashboard import comparison, runs

    return getattr(comparison if hasattr(comparison, name) else runs, name)
