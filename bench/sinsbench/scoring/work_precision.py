"""Work against precision: what each subject spends for its error, and who reaches a level of error for least."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sinsbench.scoring.crossing import crossing, interpolated

__all__ = ["COSTS", "LEVELS", "Cheapest", "Cost", "Level", "cheapest", "cost_at"]

Row = Mapping[str, Any]

COSTS = ("flops_per_second", "ns_per_second")
"""Fields that tell of cost: operations and nanoseconds a second of motion."""


@dataclass(frozen=True)
class Level:
    """A level of error.

    Attributes
    ----------
    field : str
        Field of the rows that holds the error.
    value : float
    unit : str
    """

    field: str
    value: float
    unit: str


LEVELS = (
    *(Level("attitude_error_max", 10.0**-k, "rad") for k in range(3, 13)),
    *(Level("drift_deg_per_h", 10.0**-k, "deg/h") for k in range(4)),
)
"""Levels at which costs are compared."""


@dataclass(frozen=True)
class Cost:
    """What a subject spends a second of motion to stay at or below a level of error.

    Attributes
    ----------
    subject : str
        Empty where nobody reaches the level at a known cost.
    value : float
        One of `COSTS`; NaN without a subject.
    at_most : bool
        Whether even the coarsest interval of the ladder is good enough, so that less may do.
    """

    subject: str = ""
    value: float = float("nan")
    at_most: bool = False

    @property
    def shown(self) -> str:
        """The cost with four digits."""
        return f"{'<= ' if self.at_most else ''}{self.value:.4g}" if self.subject else ""


@dataclass(frozen=True)
class Cheapest:
    """Who reaches a level of error for least.

    Attributes
    ----------
    level : Level
    by_flops, by_time : Cost
        The least operations and the least time, with their subjects.
    reached_by : int
        How many subjects reach the level.
    """

    level: Level
    by_flops: Cost
    by_time: Cost
    reached_by: int


def cost_at(rows: Sequence[Row], level: Level, cost: str) -> Cost:
    """Return what a subject spends to stay at or below a level of error, by interpolation along its ladder.

    Parameters
    ----------
    rows : sequence of mapping
        Rows of one subject on one case, coarsest interval first.
    level : Level
    cost : str
        One of `COSTS`.

    Returns
    -------
    Cost
        Without a subject where the ladder does not reach the level, or the cost is not known.
    """
    known = [row for row in rows if row[level.field] is not None and row[cost]]
    if not known:
        return Cost()
    name = known[0]["subject"]
    intervals, errors = ([float(row[field]) for row in known] for field in ("interval", level.field))
    if max(errors) <= level.value:
        return Cost(name, float(known[0][cost]), at_most=True)
    found = crossing(intervals, errors, level.value).interval
    if found is None:
        return Cost()
    # An error above the level stands before the crossing, so there is a coarser interval.
    fine = next(i for i, interval in enumerate(intervals) if interval <= found)
    ends = ((intervals[i], float(known[i][cost])) for i in (fine - 1, fine))
    (x0, y0), (x1, y1) = ends
    return Cost(name, interpolated(found, x0, y0, x1, y1))


def cheapest(rows: Sequence[Row], levels: Sequence[Level] = LEVELS) -> list[Cheapest]:
    """Return who reaches levels of error for least on one case.

    Parameters
    ----------
    rows : sequence of mapping
        Rows of several subjects on one case, each subject's coarsest interval first.
    levels : sequence of Level

    Returns
    -------
    list of Cheapest
        One a level that somebody reaches.
    """
    ladders: dict[str, list[Row]] = {}
    for row in rows:
        ladders.setdefault(row["subject"], []).append(row)
    found = []
    for level in levels:
        by_flops, by_time = ([cost_at(own, level, cost) for own in ladders.values()] for cost in COSTS)
        reached = sum(bool(x.subject or y.subject) for x, y in zip(by_flops, by_time, strict=True))
        if reached:
            found.append(Cheapest(level, _least(by_flops), _least(by_time), reached))
    return found


def _least(costs: Sequence[Cost]) -> Cost:
    return min((x for x in costs if x.subject), key=lambda x: x.value, default=Cost())
