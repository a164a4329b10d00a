"""Cases: named, validated, exactly given inputs of the datasets.

A float parameter means the binary64 it is, a string what it says (`sinsref.exact`). A bad value raises
`CaseError`, which names the field, the value and what is admissible.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from difflib import get_close_matches
from typing import Any, ClassVar, Self, TypeAlias

from sinsref.arithmetic import MpArithmetic
from sinsref.earth import SEMI_MAJOR_AXIS
from sinsref.equator import EquatorModel
from sinsref.exact import ExactNumber, ExpressionError
from sinsref.pi_monomials import PiMonomial, PiMonomialArithmetic
from sinsref.precession import DualPrecession

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,63}")
_MAXIMUM_SAMPLES = 10**9
_ZERO = ExactNumber(0)
#: Magnitudes of numbers other than 0. The few that meet in a formula then have a product far inside the range of
#: binary64, rests included.
_SMALLEST, _LARGEST = 1e-30, 1e30
#: Natural logarithm of the largest growth: times the largest error it is far inside the range of binary64.
_MAXIMUM_GROWTH = 500.0


class CaseError(ValueError):
    """A case is not admissible; the message says which field, which value, and what would do."""

    def __init__(self, field: str, value: object, admissible: str) -> None:
        super().__init__(f"{field if _is_plain(field) else _short(field)} = {_short(value)}: {admissible}")
        self.field = field


def _is_plain(text: str) -> bool:
    return len(text) <= 60 and text.isprintable()


def _short(value: object) -> str:
    if isinstance(value, int) and abs(value) > _LARGEST:  # Python refuses to print very long integers
        return f"(an integer of {value.bit_length()} bits)"
    text = value.text if isinstance(value, ExactNumber) and value.text.isprintable() else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _number(field: str, value: Any) -> ExactNumber:
    if isinstance(value, bool) or not isinstance(value, int | float | str | ExactNumber):
        raise CaseError(field, value, 'must be a number, or a string such as "pi/18"')
    out_of_range = CaseError(field, value, f"must be 0, or {_SMALLEST:g} to {_LARGEST:g} in magnitude")
    if isinstance(value, int) and abs(value) > _LARGEST:
        raise out_of_range
    try:
        number = ExactNumber(value)
    except ExpressionError as error:
        raise CaseError(field, value, str(error)) from None
    # The arithmetic of exact zeros tells 0 from what binary64 cannot.
    with PiMonomialArithmetic(256) as arithmetic:
        exact = number.evaluate(arithmetic)
        zero = isinstance(exact, PiMonomial) and not exact.coefficient
        if not (zero or _SMALLEST <= arithmetic.magnitude(exact) * (1 + 1e-9) <= _LARGEST * (1 + 3e-9)):
            raise out_of_range
    return number


def _vector(field: str, value: Any, length: int) -> tuple[ExactNumber, ...]:
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise CaseError(field, value, f"must be a list of {length} numbers")
    if len(value) != length:
        raise CaseError(field, list(value), f"must have {length} elements, not {len(value)}")
    return tuple(_number(f"{field}[{i}]", x) for i, x in enumerate(value))


def _positive(field: str, value: ExactNumber, unit: str) -> None:
    if not float(value) > 0:
        raise CaseError(field, value, f"must be greater than 0 {unit}")


def whole_intervals(duration: ExactNumber, interval: ExactNumber) -> int | None:
    """Return how many intervals a duration holds, None where that is no whole number, or less than 1 or above 1e9.

    Whole within 1e-9 of itself: 100.0 s hold 10,000 intervals of the binary64 nearest to 0.01 s.
    """
    ratio = float(duration) / float(interval)
    if not ratio < 2 * _MAXIMUM_SAMPLES:
        return None
    count = round(ratio)
    return count if 1 <= count <= _MAXIMUM_SAMPLES and abs(ratio - count) <= 1e-9 * ratio else None


class _Case:
    """What the cases of all datasets share: building from a mapping, name, whole number of intervals."""

    name: str
    interval: ExactNumber
    duration: ExactNumber
    _optional: ClassVar[frozenset[str]]
    __dataclass_fields__: ClassVar[dict[str, Any]]

    @classmethod
    def from_mapping(cls, given: Mapping[str, Any]) -> Self:
        """Build a case from the keys of a case file.

        Raises
        ------
        CaseError
            For unknown or missing keys and for inadmissible values.
        """
        known = [field.name for field in fields(cls)]
        for key in given:
            if key not in known:
                near = get_close_matches(key, known, 1)
                hint = f"did you mean {near[0]!r}?" if near else f"admissible keys: {', '.join(known)}"
                raise CaseError(key, given[key], f"unknown key; {hint}")
        for key in known:
            if key not in given and key not in cls._optional:
                raise CaseError(key, "(missing)", f"is required; keys: {', '.join(known)}")
        return cls(**given)

    def _convert(self, **values: Any) -> None:
        for field, value in values.items():
            object.__setattr__(self, field, value)

    def _check_name_and_sampling(self) -> None:
        if not isinstance(self.name, str) or not _NAME.fullmatch(self.name):
            raise CaseError("name", self.name, "must be 1 to 64 letters, digits, or _ . + -")
        _positive("interval", self.interval, "s")
        _positive("duration", self.duration, "s")
        if whole_intervals(self.duration, self.interval) is None:
            ratio = float(self.duration) / float(self.interval)
            whole = min(max(1, round(ratio)), _MAXIMUM_SAMPLES) * float(self.interval)
            raise CaseError(
                "duration",
                self.duration,
                f"must be a whole number of intervals, at most 1e9; near it: {whole:.12g} s",
            )

    @property
    def samples(self) -> int:
        """The number n of intervals; epochs are k * interval, exactly, for k = 0 ... n."""
        return whole_intervals(self.duration, self.interval) or 0


@dataclass(frozen=True)
class EquatorCase(_Case):
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
        self._convert(**{field: _number(field, getattr(self, field)) for field in names})
        self._convert(initial_errors=_vector("initial_errors", self.initial_errors, 6))
        rows: Any = self.misalignment
        if rows is not None:
            if isinstance(rows, str) or not isinstance(rows, Sequence) or len(rows) != 3:
                raise CaseError("misalignment", rows, "must be 3 lists of 3 numbers")
            matrix = tuple(_vector(f"misalignment[{i}]", row, 3) for i, row in enumerate(rows))
            # A zero matrix is no misalignment: one meaning, one form.
            self._convert(misalignment=matrix if any(float(x) for row in matrix for x in row) else None)
        self._check_name_and_sampling()
        if float(self.height) <= -float(SEMI_MAJOR_AXIS):
            raise CaseError("height", self.height, f"must be above the Earth's centre, {-float(SEMI_MAJOR_AXIS):.0f} m")
        ar = MpArithmetic(30)
        model = EquatorModel.at(ar, self.v_east, self.height)
        growth = (ar.magnitude(model.p) + ar.magnitude(model.q) ** 0.5) ** 0.5
        if growth * float(self.duration) > _MAXIMUM_GROWTH:
            raise CaseError(
                "duration",
                self.duration,
                f"the errors would leave the range of binary64; at this speed at most {_MAXIMUM_GROWTH / growth:.6g} s",
            )


@dataclass(frozen=True)
class DualPrecessionCase(_Case):
    """Regular precession with its dual analogue: a case of `dual_precession`.

    Attributes
    ----------
    name : str
    spin_rate : ExactNumber
        nu, rad/s.
    precession_ratio : ExactNumber
        eps, precession rate over spin rate; -1 is classical coning.
    nutation : ExactNumber
        theta, rad.
    spin_rate_dual : ExactNumber
        nu0, m/s^2.
    nutation_dual : ExactNumber
        theta0, m/s.
    initial_velocity : tuple of 3 ExactNumber
        Apparent velocity at t = 0, inertial axes, m/s.
    interval, duration : ExactNumber
        Sampling interval h and duration, s.
    initial_attitude : tuple of 4 ExactNumber, or None
        Quaternion body to inertial at t = 0, scalar first, of norm 1 within 1e-6 and normalised exactly; None for
        the attitude in which the precession axis is the inertial z axis.
    """

    name: str
    spin_rate: ExactNumber
    precession_ratio: ExactNumber
    nutation: ExactNumber
    spin_rate_dual: ExactNumber
    nutation_dual: ExactNumber
    initial_velocity: tuple[ExactNumber, ...]
    interval: ExactNumber
    duration: ExactNumber
    initial_attitude: tuple[ExactNumber, ...] | None = None

    _optional: ClassVar[frozenset[str]] = frozenset({"initial_attitude"})

    def __post_init__(self) -> None:
        names = (
            "spin_rate", "precession_ratio", "nutation", "spin_rate_dual", "nutation_dual", "interval", "duration",
        )  # fmt: skip
        self._convert(**{field: _number(field, getattr(self, field)) for field in names})
        self._convert(initial_velocity=_vector("initial_velocity", self.initial_velocity, 3))
        if self.initial_attitude is not None:
            self._convert(initial_attitude=_vector("initial_attitude", self.initial_attitude, 4))
            norm = sum(float(x) ** 2 for x in self.initial_attitude) ** 0.5
            if abs(norm - 1) > 1e-6:
                texts = [x.text for x in self.initial_attitude]
                raise CaseError("initial_attitude", texts, f"must have norm 1 within 1e-6, not {norm:.9g}")
        self._check_name_and_sampling()
        if float(self.spin_rate) == 0:
            raise CaseError("spin_rate", self.spin_rate, "must not be 0: the precession rate is given in units of it")

    @property
    def motion(self) -> DualPrecession:
        """The motion without its sampling."""
        return DualPrecession(
            self.spin_rate,
            self.precession_ratio,
            self.nutation,
            self.spin_rate_dual,
            self.nutation_dual,
            self.initial_attitude,
            self.initial_velocity,
        )


#: A case of any dataset.
Case: TypeAlias = EquatorCase | DualPrecessionCase

#: The class of the cases of each dataset.
CASE_CLASSES: Mapping[str, type[EquatorCase | DualPrecessionCase]] = {
    "equator_errors": EquatorCase,
    "dual_precession": DualPrecessionCase,
}
