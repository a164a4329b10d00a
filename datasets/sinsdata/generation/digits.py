"""The digits of a few values as decimal text: to compare by eye, or with any language, without any library."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from decimal import Context, Decimal
from typing import Any

from sinsdata.format.schema import DATASETS
from sinsdata.generation.specification import Specification
from sinsdata.generation.tables import Segment
from sinsref.rounding import RoundingTally

NAME = "digits.csv"
#: Significant digits: those that x + x_lo proves.
DIGITS = 30
#: Cases of which a row is written.
_CASES = 24
_ALONE = Context(prec=17)
_HEADER = "table,case,row,column,unit,value"


def digits_text(specification: Specification) -> str:
    """Return the table of digits: of up to 24 cases and each of their tables one row.

    The value is the sum of x and x_lo, exact in decimal, then rounded to 30 digits.
    """
    return "\n".join([_HEADER, *_lines(specification)]) + "\n"


def decimal_text(context: Context, row: Mapping[str, Any], name: str) -> str:
    """Return a value of a row: x and x_lo together to 30 digits, x alone to the 17 that tell binary64 apart."""
    high = row[name]
    if high is None:
        return ""
    if f"{name}_lo" not in row:
        return str(_ALONE.plus(Decimal(high)))
    low = row[f"{name}_lo"]
    return "" if low is None else str(context.add(Decimal(high), Decimal(low)))


def spot_rows(specification: Specification) -> Iterator[tuple[int, Segment]]:
    """Yield which rows are written: number of the group, and a segment of one row."""
    count = len(specification.cases)
    chosen = sorted({number * count // min(count, _CASES) for number in range(min(count, _CASES))})
    for group, about in enumerate(specification.groups):
        if about.tables == ("cases",):
            continue
        for place, number in enumerate(chosen):
            case = specification.cases[number]
            # From row to row another part of the motion; rows that are costly the later they are, early ones.
            rows = min(about.rows(case), about.spot_limit)
            if rows:
                yield group, Segment(case, (rows - 1) * (place + 1) // len(chosen), 1)


def _lines(specification: Specification) -> Iterator[str]:
    context = Context(prec=DIGITS)
    for number, segment in spot_rows(specification):
        group = specification.groups[number]
        (batches,) = group.batches(specification.tier, [segment], RoundingTally())
        for table, batch in zip(group.tables, batches, strict=True):
            (row,) = batch.to_pylist()
            for column in DATASETS[specification.dataset].tables[table]:
                if column.kind in ("pair", "value"):
                    value = decimal_text(context, row, column.name)
                    yield f"{table},{segment.case.name},{segment.first},{column.name},{column.unit},{value}"
