"""Rows of results as the commands write them, for reports."""

from dataclasses import asdict
from typing import Any

from sinsbench.claims.model import ClaimResult
from sinsbench.mutants.runner import Mutant

PRECESSION = ("panov2", "panov4")
EQUATOR = ("equator_corrected", "expm")
CASE = "coning_003"


def claim(identifier: str, printed: str, computed: float | str, verdict: str) -> dict[str, Any]:
    difference = (float(printed) - computed) / computed if isinstance(computed, float) else None
    row = ClaimResult(
        "lebedev1989", identifier, "section 6, row 1", "drift <of attitude>", printed, "deg/h", computed, difference,
        verdict == "reproduced", verdict, "a note",
    )  # fmt: skip
    return row.to_row()


CLAIMS = [
    claim("first", "1.5", 1.5004, "reproduced"),
    claim("second", "2.5", 1.25, "misprint"),
    claim("third", "3.5", 9.0, "not reproduced"),
    claim("word", "order", "order", "reproduced"),
]
MUTANTS = [
    asdict(Mutant("panov4", "coefficient", "sign of the first", "told apart", told_by="a cone")),
    asdict(Mutant("panov4", "source", "0 -> 1", "equivalent", reason="never used")),
    asdict(Mutant("panov2", "source", "a + b -> a - b", "survivor")),
]
STORIES = [{"title": "lebedev1989: a tale", "sentence": "It is so.", "rows": [{"bits": 35, "velocity": 1.25e-6}]}]
DATASETS = [{"dataset": "dual_precession", "values": 1000, "checks that hold": 40, "checks that fail": 0}]
CHECKS = [
    {"where": "data/x", "what": "hash", "holds": True, "detail": ""},
    {"where": "data/x", "what": "rows", "holds": False, "detail": "one is missing"},
]
ENVIRONMENT = {"python": "3.11.0", "machine": "riscv64", "system": "Linux", "sinsbench": "0.0.1"}


def stored_run(number: int, seconds: float) -> dict[str, Any]:
    """Return a stored benchmark run whose only benchmark takes as long as given."""
    times = [seconds * (1 + n / 1000) for n in range(30)]
    stats = {"min": times[0], "median": times[15], "rounds": 30, "samples": times}
    return {
        "machine_info": {"system": "Linux", "machine": "riscv64", "python_version": "3.11.0", "cpu": {"count": 2}},
        "commit_info": {"id": f"{number:040x}", "dirty": False},
        "datetime": f"2026-01-0{number}T00:00:00+00:00",
        "benchmarks": [{"group": "g", "name": "b", "fullname": "suites/b.py::b", "stats": stats, "extra_info": {}}],
    }
