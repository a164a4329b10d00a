"""What a gyroscopic subject is given, what it refuses, and how either is checked."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.increments import checked_array, finite_over_time
from sinsbench.subjects.outcome import OutcomeError

__all__ = ["BrokenConditionError", "Inputs", "Start"]

Array = NDArray[np.float64]

_UNEVEN = 1e-6  # of the spacing: times printed to a microsecond pass, a missing sample does not


class BrokenConditionError(OutcomeError):
    """A condition of the equations does not hold.

    Parameters
    ----------
    condition : str
        The condition, such as ``h > 0``.
    time : float
        When it was first found broken, s.
    """

    def __init__(self, condition: str, time: float) -> None:
        super().__init__("not applicable", f"{condition} does not hold, first at t = {time:.9g} s")
        self.condition = condition
        self.time = time


@dataclass(frozen=True)
class Inputs:
    """Sensors at equidistant times.

    Attributes
    ----------
    time : ndarray, shape (n + 1,)
        Times of the points, or of the ends of the samples, s.
    rate, specific_force : ndarray
        Shape (n + 1, 3): rates Omega_xi, rad/s, and specific force a_xi, m/s^2, in vehicle axes at these times. With
        ``kind`` "increments" shape (n, 3): their integrals over the samples, rad and m/s.
    aids : mapping of str to ndarray, each of shape (n + 1,)
        What else is known at these times: ``radius`` and ``radius_rate`` of an altimeter, ``speed``, and so on.
    kind : {"points", "increments"}
    """

    time: Array
    rate: Array
    specific_force: Array
    aids: Mapping[str, Array] = field(default_factory=dict)
    kind: Literal["points", "increments"] = "points"

    def checked(self, per_step: int) -> "Inputs":
        """Return the inputs as float64 arrays.

        Parameters
        ----------
        per_step : int
            Number of intervals that a step spans: 2 with points, 4 with increments.

        Raises
        ------
        ValueError
            If a shape is wrong, a value is not finite (which says when), times are not equidistant (a gap, which says
            where), or the intervals do not make whole steps.
        """
        time = checked_array("time", self.time, (None,))
        n = time.size - 1
        if n < per_step or n % per_step:
            raise ValueError(f"time has {n} intervals, expected a multiple of {per_step}, the intervals of a step")
        spacing = (time[-1] - time[0]) / n
        if not spacing > 0:
            raise ValueError(f"time runs from {time[0]} to {time[-1]} s, expected increasing times")
        # Long records of a short interval: the times themselves are rounded.
        allowed = max(_UNEVEN * spacing, 4 * float(np.spacing(np.abs(time).max())))
        steps = np.diff(time)
        usual = float(np.median(steps))
        deviation = np.abs(steps - usual)
        if deviation.max() > allowed:
            worst = int(np.argmax(deviation))
            raise ValueError(
                f"sampling gap: {steps[worst]:.9g} s between t = {time[worst]:.9g} s and {time[worst + 1]:.9g} s, "
                f"{usual:.9g} s elsewhere"
            )
        rows = n + 1 if self.kind == "points" else n
        ends = time if self.kind == "points" else time[1:]
        return Inputs(
            time,
            finite_over_time("rate", self.rate, (rows, 3), ends),
            finite_over_time("specific_force", self.specific_force, (rows, 3), ends),
            {name: finite_over_time(name, values, (n + 1,), time) for name, values in self.aids.items()},
            self.kind,
        )

    @property
    def interval(self) -> float:
        """Distance of the times, s."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))


@dataclass(frozen=True)
class Start:
    """Motion of the vehicle at the start, and the sphere that it moves on.

    Attributes
    ----------
    attitude : ndarray, shape (4,)
        s, from vehicle axes xi to the non-rotating axes X.
    vertical : ndarray, shape (3,)
        Unit vector r^ of the local vertical in X.
    velocity : ndarray, shape (3,)
        Absolute velocity in X, m/s; its vertical part does not matter to the systems on a sphere.
    radius : float
        Radius R of the sphere, m.
    gravity : float
        Gravitational acceleration g on it, m/s^2.
    turn_rate : float, optional
        Rate w3 of the Darboux trihedron about the vertical, rad/s: what a start at equilibrium asks for.
    distance : float, optional
        From the centre, m: what Newton's equation starts from; that of the sphere where it is not told.
    """

    attitude: Array
    vertical: Array
    velocity: Array
    radius: float = 6371000.0
    gravity: float = 9.81
    turn_rate: float | None = None
    distance: float | None = None

    def checked(self) -> "Start":
        """Return the start as float64 arrays.

        Raises
        ------
        ValueError
            If a shape is wrong, a value is not finite, a norm is not 1, or radius or gravity is not positive.
        """
        attitude, vertical, velocity = (
            checked_array(name, getattr(self, name), shape)
            for name, shape in (("attitude", (4,)), ("vertical", (3,)), ("velocity", (3,)))
        )
        for name, value in (("attitude", attitude), ("vertical", vertical)):
            if abs(np.linalg.norm(value) - 1) > 1e-9:  # far above rounding, far below any other meaning
                raise ValueError(f"{name} has the norm {np.linalg.norm(value)}, expected 1")
        for name in ("radius", "gravity", *(("distance",) if self.distance is not None else ())):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise ValueError(f"{name} = {getattr(self, name)}: a positive number is needed")
        if self.turn_rate is not None and not np.isfinite(self.turn_rate):
            raise ValueError(f"turn_rate = {self.turn_rate}: a finite number is needed")
        sphere = float(self.radius), float(self.gravity)
        return Start(attitude, vertical, velocity, *sphere, self.turn_rate, self.distance)

    @property
    def tangential_velocity(self) -> Array:
        """Horizontal part of the absolute velocity, m/s; exactly 0 where it is but rounding of a vertical velocity."""
        level = self.velocity - self.vertical * (self.vertical @ self.velocity)
        rounding = 4 * np.finfo(float).eps * np.linalg.norm(self.velocity)
        return np.asarray(level if np.linalg.norm(level) > rounding else np.zeros(3))

    @property
    def speed(self) -> float:
        """Absolute horizontal speed, m/s."""
        return float(np.linalg.norm(self.tangential_velocity))

    @property
    def schuler_speed(self) -> float:
        """V = sqrt(g R), m/s."""
        return float(np.sqrt(self.gravity * self.radius))

    def axes(self) -> Array:
        """Darboux trihedron of the absolute motion: its axes y1 (velocity), y2 (left), y3 (up) as rows, in X.

        Raises
        ------
        BrokenConditionError
            If the speed is zero, which leaves the trihedron undefined.
        """
        if not self.speed > 0:
            raise BrokenConditionError("absolute speed > 0", 0.0)
        y1 = self.tangential_velocity / self.speed
        return np.array([y1, np.cross(self.vertical, y1), self.vertical])
