"""Comparisons of results in ball arithmetic with the balls they must agree with."""

from collections.abc import Iterable, Sequence

from flint import arb

#: Precision of the modules that are compared.
BITS = 160


def agree(found: Iterable[arb], expected: Sequence[arb], tolerance: float = 1e-30) -> bool:
    """Whether balls overlap one by one and are close relative to the largest."""
    scale = max(float(abs(x).abs_upper()) for x in expected)
    pairs = list(zip(found, expected, strict=True))
    return all(arb(x).overlaps(y) and abs(arb(x) - y) < tolerance * scale for x, y in pairs)


def agree_alone(x: arb, y: arb) -> bool:
    """Whether two balls overlap and are close relative to themselves."""
    return bool(x.overlaps(y) and abs(x - y) < 1e-30 * abs(y))


def near(found: Iterable[arb], expected: Iterable[arb]) -> bool:
    """As far as a Taylor integration of order 45 reaches: 0.9^45/45! is 1e-58, and balls of 160 bits."""
    return all(abs(x - y) < 1e-35 * (1 + abs(y)) for x, y in zip(found, expected, strict=True))
