"""Cases of regular precession with its dual analogue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sinsdata.cases.base import CaseError, SampledCase, checked_number, checked_vector
from sinsref.exact import ExactNumber
from sinsref.precession import DualPrecession


@dataclass(frozen=True)
class DualPrecessionCase(SampledCase):
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
        self._convert(**{field: checked_number(field, getattr(self, field)) for field in names})
        self._convert(initial_velocity=checked_vector("initial_velocity", self.initial_velocity, 3))
        if self.initial_attitude is not None:
            self._convert(initial_attitude=checked_vector("initial_attitude", self.initial_attitude, 4))
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
