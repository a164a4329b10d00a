"""Comparison of stored runs: what became slower, by how much, at which commit.

As airspeed velocity does it: runs of one machine, a factor, and the test of Mann and Whitney [1]_; by minimum and
median, never the mean, which a busy machine moves at will.

References
----------
.. [1] H. B. Mann, D. R. Whitney, "On a test of whether one of two random variables is stochastically larger than the
   other", Annals of Mathematical Statistics 18 (1947), 50-60.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import comb
from typing import Any

from sinsbench.dashboard.runs import Run, Timing
from sinsbench.scoring.rows import Field

__all__ = ["COMPARISON_FIELDS", "FACTOR", "LEVEL", "VERDICTS", "compared", "standing_regressions"]

FACTOR = 1.1
"""Ratio of times from which on there is a change."""

LEVEL = 0.002
"""Probability, were nothing changed, of samples as different as these: from there down there is a change."""

VERDICTS = ("first", "same", "slower", "faster", "undecided")
"""What a run tells of a benchmark; "undecided": the factor is exceeded, but the rounds are too few for the test."""

COMPARISON_FIELDS = (
    Field("machine", "", "system, architecture, processor, cores, Python"),
    Field("group", "", "group of the benchmark"),
    Field("benchmark", "", "full name of the benchmark"),
    Field("run", "", "file of the run"),
    Field("time", "", "when the run was made"),
    Field("commit", "", "commit of the run; empty for none"),
    Field("dirty", "", "whether the checkout differed from the commit"),
    Field("minimum", "s", "least time of a round"),
    Field("median", "s", "median time of a round"),
    Field("rounds", "", "rounds of the benchmark"),
    Field("calibration_ns", "ns", "time of the calibration workload beside it"),
    Field("baseline_commit", "", "commit of the run compared with: the first, or the last that was slower or faster"),
    Field("ratio_minimum", "", "minimum over that of the baseline"),
    Field("ratio_median", "", "median over that of the baseline"),
    Field("ratio_calibration", "", "calibration over that of the baseline: how much slower the machine itself was"),
    Field("p_value", "", "probability of samples as different, were nothing changed (Mann, Whitney, two-sided)"),
    Field("verdict", "", f"one of: {', '.join(VERDICTS)}"),
)


def compared(runs: Sequence[Run], factor: float = FACTOR) -> list[dict[str, Any]]:
    """Compare every run with the one since which its benchmark took as long.

    Parameters
    ----------
    runs : sequence of Run
        In any order, of any machines; runs of different machines are never compared.
    factor : float
        Ratio of times from which on there is a change.

    Returns
    -------
    list of dict
        Rows with the fields `COMPARISON_FIELDS`: by machine and benchmark, oldest run first. "slower" says that minimum
        and median both exceed those of the baseline by the factor, as they were timed and relative to the calibration
        workload before and after, and that the samples differ at the level `LEVEL`; "faster" likewise. Such a run is
        the next baseline, so that a step is marked once, and many small steps as soon as they add up to the factor.
    """
    ordered = sorted(runs, key=lambda run: run.time)
    places = dict.fromkeys((run.machine, name) for run in ordered for name in run.timings)
    rows: list[dict[str, Any]] = []
    for machine, name in sorted(places):
        baseline: tuple[Run, Timing] | None = None
        for run in ordered:
            if run.machine != machine or name not in run.timings:
                continue
            timing = run.timings[name]
            told = {"verdict": "first"} if baseline is None else _change(*baseline, timing, factor)
            if told["verdict"] in ("first", "slower", "faster"):
                baseline = run, timing
            rows.append(_row(run, name, timing) | told)
    return rows


def _row(run: Run, name: str, timing: Timing) -> dict[str, Any]:
    known = {
        "machine": run.machine,
        "group": timing.group,
        "benchmark": name,
        "run": run.file,
        "time": run.time,
        "commit": run.commit,
        "dirty": run.dirty,
        "minimum": timing.minimum,
        "median": timing.median,
        "rounds": timing.rounds,
        "calibration_ns": timing.calibration_ns,
    }
    return {field.name: known.get(field.name) for field in COMPARISON_FIELDS}


def _change(run: Run, before: Timing, after: Timing, factor: float) -> dict[str, Any]:
    ratios = after.minimum / before.minimum, after.median / before.median
    machine = _over(after.calibration_ns, before.calibration_ns)
    # What the machine may have been slower by, and faster. Either excuses a benchmark that took longer or less long;
    # none accuses one that took as long as ever.
    slowest = _over(after.calibration_most_ns, before.calibration_ns)
    fastest = _over(after.calibration_ns, before.calibration_most_ns)
    every = [ratio / unit for ratio in ratios for unit in (1.0, slowest or 1.0, fastest or 1.0)]
    p_value = _p_value(before.samples, after.samples)
    if factor >= min(every) and max(every) >= 1 / factor:
        verdict = "same"
    elif p_value is None:
        verdict = "undecided"
    else:
        verdict = ("slower" if min(every) > factor else "faster") if p_value < LEVEL else "same"
    return {
        "baseline_commit": run.commit,
        "ratio_minimum": ratios[0],
        "ratio_median": ratios[1],
        "ratio_calibration": machine,
        "p_value": p_value,
        "verdict": verdict,
    }


def _over(after: float | None, before: float | None) -> float | None:
    return None if after is None or before is None else after / before


def _p_value(before: Sequence[float], after: Sequence[float]) -> float | None:
    """Return the probability of samples as different, None where so few could never fall below `LEVEL`."""
    if 2 / comb(len(before) + len(after), len(after)) >= LEVEL:
        return None
    from scipy.stats import mannwhitneyu  # half a second

    return float(mannwhitneyu(before, after, alternative="two-sided").pvalue)


def standing_regressions(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return the rows of `compared` that are slower, without those that a faster run of the same benchmark followed."""
    standing: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for row in rows:
        place = row["machine"], row["benchmark"]
        if row["verdict"] == "slower":
            standing.setdefault(place, []).append(row)
        elif row["verdict"] == "faster":
            standing.pop(place, None)
    return [row for group in standing.values() for row in group]
