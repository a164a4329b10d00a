"""Cases of flight along the equator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

from sinsdata.cases.base import CaseError, SampledCase, checked_number, checked_vector
from sinsref.arithmetic import MpArithmetic
from sinsref.earth import SEMI_MAJOR_AXIS
from sinsref.equator import EquatorModel
from sinsref.exact import ExactNumber

_ZERO = ExactNumber(0)
#: Natural logarithm of the largest growth: times the largest error it is far inside the range of binary64.
_MAXIMUM_GROWTH = 500.0


@lru_cache(maxsize=4096)
def _growth_rate(v_east: ExactNumber, height: ExactNumber) -> float:
    """Return a bound of the rate at which errors grow, 1/s."""
    ar = MpArithmetic(30)
    model = EquatorModel.at(ar, v_east, height)
    return float((ar.magnitude(model.p) + ar.magnitude(model.q) ** 0.5) ** 0.5)


@dataclass(frozen=True)
class EquatorCase(SampledCase):
    """Flight along the equator: a case of `equator_errors`.

    Attributes
    ----------
    name : str
    v_east : ExactNumber
        Speed over the Earth, m/s.
    height : ExactNumber
        m.
    duration, interval : ExactNumber
        s.
    initial_errors : tuple of 6 ExactNumber
        dv_N, dv_H, dv_E (m/s), dH (m), dphi, dlambda (rad); computed minus true.
    misalignment : tuple of 3 tuples of 3 ExactNumber, or None
        Initial error of the orientation in the inertial frame, the matrix of (8).
    inertial_longitude : ExactNumber
        Inertial longitude at t = 0, rad.
    """

    name: str
    v_east: ExactNumber
    height: ExactNumber
    duration: ExactNumber
    interval: ExactNumber
    initial_errors: tuple[ExactNumber, ...]
    misalignment: tuple[tuple[ExactNumber, ...], ...] | None = None
    inertial_longitude: ExactNumber = _ZERO

    _optional: ClassVar[frozenset[str]] = frozenset({"misalignment", "inertial_longitude"})

    def __post_init__(self) -> None:
        names = ("v_east", "height", "duration", "interval", "inertial_longitude")
        self._convert(**{field: checked_number(field, getattr(self, field)) for field in names})
        self._convert(initial_errors=checked_vector("initial_errors", self.initial_errors, 6))
        rows: Any = self.misalignment
        if rows is not None:
            if isinstance(rows, str) or not isinstance(rows, Sequence) or len(rows) != 3:
                raise CaseError("misalignment", rows, "must be 3 lists of 3 numbers")
            matrix = tuple(checked_vector(f"misalignment[{i}]", row, 3) for i, row in enumerate(rows))
            # A zero matrix is no misalignment: one meaning, one form.
            self._convert(misalignment=matrix if any(float(x) for row in matrix for x in row) else None)
        self._check_name_and_sampling()
        if float(self.height) <= -float(SEMI_MAJOR_AXIS):
            raise CaseError("height", self.height, f"must be above the Earth's centre, {-float(SEMI_MAJOR_AXIS):.0f} m")
        growth = _growth_rate(self.v_east, self.height)
        if growth * float(self.duration) > _MAXIMUM_GROWTH:
            raise CaseError(
                "duration",
                self.duration,
                f"the errors would leave the range of binary64; at this speed at most {_MAXIMUM_GROWTH / growth:.6g} s",
            )
