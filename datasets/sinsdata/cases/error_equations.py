"""Cases of flight along a parallel, a meridian, a great circle and in a climbing turn."""

from __future__ import annotations

from dataclasses import dataclass
from math import log, pi, sqrt
from typing import Any, ClassVar, TypeAlias

from sinsdata.cases.base import CaseError, SampledCase, checked_number, checked_vector
from sinsref.earth import ECCENTRICITY_SQUARED, EQUATORIAL_GRAVITY, SEMI_MAJOR_AXIS
from sinsref.exact import ExactNumber

_Optional: TypeAlias = ExactNumber | None

#: The keys that a motion needs beyond those that all motions have.
MOTIONS: dict[str, tuple[str, ...]] = {
    "parallel": (),
    "meridian": (),
    "great_circle": ("heading",),
    "climbing_turn": ("heading", "climb_rate", "turn_rate"),
}
_OWN = MOTIONS["climbing_turn"]
#: Where the frame north-up-east is still used, rad from a pole.
POLE_CLEARANCE = 1e-3
#: Largest magnitudes: speed and climb rate, m/s; centripetal acceleration of a turn, m/s^2; heights, m.
_SPEED, _CLIMB, _CENTRIPETAL, _LOWEST, _HIGHEST = 2000.0, 300.0, 100.0, -1e4, 1e6
#: To what part of the Earth's radius the errors may grow: the solution of the nonlinear equations must exist.
_LARGEST_ERROR = 0.2


@dataclass(frozen=True)
class ErrorEquationCase(SampledCase):
    """Flight that is not along the equator: a case of `error_equations`.

    Attributes
    ----------
    name : str
    motion : {"parallel", "meridian", "great_circle", "climbing_turn"}
    latitude, longitude : ExactNumber
        At the start, rad.
    height : ExactNumber
        At the start, m.
    speed : ExactNumber
        Horizontal speed over the Earth, m/s; negative on a parallel for west, on a meridian for south.
    duration, interval : ExactNumber
        s.
    initial_errors : tuple of 6 ExactNumber
        dv_N, dv_H, dv_E (m/s), dH (m), dphi, dlambda (rad); computed minus true; not all 0.
    heading : ExactNumber, optional
        At the start, clockwise from north, rad; great circle and climbing turn.
    climb_rate : ExactNumber, optional
        v_H, m/s; climbing turn.
    turn_rate : ExactNumber, optional
        Rate of the heading, rad/s; climbing turn.

    Raises
    ------
    CaseError
        For values out of range; for a key that the motion does not have, or lacks; if the motion may come within
        1e-3 rad of a pole; if the errors may grow beyond what the nonlinear equations bear.
    """

    name: str
    motion: str
    latitude: ExactNumber
    longitude: ExactNumber
    height: ExactNumber
    speed: ExactNumber
    duration: ExactNumber
    interval: ExactNumber
    initial_errors: tuple[ExactNumber, ...]
    heading: _Optional = None
    climb_rate: _Optional = None
    turn_rate: _Optional = None

    _optional: ClassVar[frozenset[str]] = frozenset(_OWN)

    def __post_init__(self) -> None:
        if not isinstance(self.motion, str) or self.motion not in MOTIONS:
            raise CaseError("motion", self.motion, f"must be one of {', '.join(MOTIONS)}")
        for field in _OWN:
            value: Any = getattr(self, field)
            if (value is not None) != (field in MOTIONS[self.motion]):
                what = "has no such key" if value is not None else "needs it"
                raise CaseError(field, value, f"the motion {self.motion!r} {what}")
        names = ("latitude", "longitude", "height", "speed", "duration", "interval", *MOTIONS[self.motion])
        self._convert(**{field: checked_number(field, getattr(self, field)) for field in names})
        self._convert(initial_errors=checked_vector("initial_errors", self.initial_errors, 6))
        self._check_name_and_sampling()
        self._check_motion()
        self._check_errors()

    def _check_motion(self) -> None:
        climb, turn = float(self.climb_rate or 0), float(self.turn_rate or 0)
        bounds = {
            "speed": _SPEED,
            "climb_rate": _CLIMB,
            # A turn on the spot would have any rate.
            "turn_rate": _CENTRIPETAL / max(abs(float(self.speed)), _CENTRIPETAL),
        }
        for (field, bound), value in zip(bounds.items(), (float(self.speed), climb, turn), strict=True):
            if abs(value) > bound:
                raise CaseError(field, getattr(self, field), f"must be at most {bound:g} in magnitude")
        # H' = v_H / alpha, and alpha is at least sqrt(1 - e^2).
        end = float(self.height) + climb * float(self.duration) / sqrt(1 - float(ECCENTRICITY_SQUARED))
        for field, height in (("height", float(self.height)), ("climb_rate", end)):
            if not _LOWEST <= height <= _HIGHEST:
                given = getattr(self, field)
                raise CaseError(field, given, f"the height must stay between {_LOWEST:g} and {_HIGHEST:g} m")
        if self.pole_clearance < POLE_CLEARANCE:
            raise CaseError("latitude", self.latitude, f"the motion may come within {POLE_CLEARANCE:g} rad of a pole")

    def _check_errors(self) -> None:
        errors = [abs(float(x)) for x in self.initial_errors]
        if not any(errors):
            raise CaseError("initial_errors", list(errors), "must not all be 0: the errors would stay 0")
        limit = min(_LARGEST_ERROR, self.pole_clearance / 2)
        if self.error_size > limit:
            raise CaseError("initial_errors", errors, f"must be below {limit:.3g} of the Earth's radius")
        longest = log(limit / self.error_size) / self._growth_rate
        if float(self.duration) > longest:
            raise CaseError(
                "duration",
                self.duration,
                f"the errors may grow beyond {limit:.3g} of the Earth's radius; at most {longest:.6g} s",
            )

    @property
    def pole_clearance(self) -> float:
        """A lower bound of the distance from the poles during the motion, rad."""
        lowest = min(float(self.height), _LOWEST)
        radius = (float(SEMI_MAJOR_AXIS) + lowest) * (1 - float(ECCENTRICITY_SQUARED))  # at most R_2
        reach = 0.0 if self.motion == "parallel" else abs(float(self.speed)) * float(self.duration) / radius
        return pi / 2 - abs(float(self.latitude)) - reach

    @property
    def error_size(self) -> float:
        """The size of the initial errors, in parts of the Earth's radius and of the speed sqrt(g a)."""
        radius, orbital = float(SEMI_MAJOR_AXIS), sqrt(float(EQUATORIAL_GRAVITY) * float(SEMI_MAJOR_AXIS))
        units = (orbital, orbital, orbital, radius, 1.0, 1.0)
        return max(abs(float(x)) / unit for x, unit in zip(self.initial_errors, units, strict=True))

    @property
    def _growth_rate(self) -> float:
        """An estimate, from above, of the rate at which the errors grow, 1/s: the height's, and what a motion adds."""
        radius, speed = float(SEMI_MAJOR_AXIS), abs(float(self.speed))
        turning = abs(float(self.turn_rate or 0)) * speed
        return sqrt((2 * float(EQUATORIAL_GRAVITY) + turning) / radius) + speed / radius
