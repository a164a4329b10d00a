"""The second path to the rows of `gyro_systems`: mpmath, derivatives by definition, plain Taylor series."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import ceil

from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.truth.gyroscopic import truth_row, with_verticals
from sinsref.arithmetic import BallArithmetic, MpArithmetic, Number
from sinsref.gyroscopic import Kinematics, Place, literal_sensors
from sinsref.gyroscopic_systems import axis_rate, start, usual_tuning
from sinsref.series import Series, SeriesArithmetic
from sinsref.taylor import integrate

_DIGITS, _ORDER = 60, 32
#: Places of a motion at which one looks how quickly it changes.
_PLACES = 64
_ANGLES = ("latitude", "longitude", "heading", "pitch", "roll")


def exact_truth(case: GyroCase, rows: Iterable[int]) -> Iterator[list[Number]]:
    """Yield time and the 23 values of rows of ``truth`` by mpmath."""
    ar = MpArithmetic(_DIGITS)
    kinematics = Kinematics(ar, case.model)
    for row in rows:
        time = ar.number(case.interval) * row
        yield [time, *truth_row(ar, kinematics, time)]


def exact_sensors(case: GyroCase, rows: Iterable[int]) -> Iterator[list[Number]]:
    """Yield time and the 12 values of rows of ``sensors``: the definition of the rates, and their integrals."""
    ar = MpArithmetic(_DIGITS)
    interval = ar.number(case.interval)

    def field(series: SeriesArithmetic, time: Series, state: list[Series]) -> list[Number]:
        kinematics = Kinematics(series, case.model)
        return kinematics.sensors(kinematics.place(time), time)

    steps = ceil(float(case.interval) / _plain_step(case))
    for row in rows:
        end, zeros = interval * row, [ar.number(0)] * 6
        begin = end - interval
        increments = integrate(ar, field, zeros, begin, end, steps=steps, order=_ORDER) if row else zeros
        yield [end, *literal_sensors(ar, case.model, end), *increments]


def exact_reference(case: GyroCase, rows: Iterable[int]) -> Iterator[list[Number]]:
    """Yield time and the 18 values of rows of ``reference``; the integration goes no further than the last row."""
    ar = MpArithmetic(_DIGITS)
    interval, (_, kappa) = ar.number(case.interval), usual_tuning(ar, case.model)
    begin = start(ar, case.model)
    state, epoch, step = [*begin.paper, *begin.equilibrium], 0, _plain_step(case)

    def field(series: SeriesArithmetic, time: Series, axes: list[Series]) -> list[Number]:
        force = Kinematics(series, case.model).force_x(time)
        signs = (kappa, -kappa, kappa, -kappa)
        return [x for n, sign in enumerate(signs) for x in axis_rate(sign, axes[3 * n : 3 * n + 3], force)]

    for row in rows:
        if row > epoch:
            steps = ceil(float(case.interval) * (row - epoch) / step)
            state = integrate(ar, field, state, interval * epoch, interval * row, steps=steps, order=_ORDER)
            epoch = row
        yield [interval * row, *with_verticals(ar, state)]


def _plain_step(case: GyroCase) -> float:
    """Return a step, s, at which a term of order 32 is below 1e-45."""
    with BallArithmetic(64) as balls:
        kinematics, duration = Kinematics(balls, case.model), balls.number(case.duration)
        times = [duration * k / _PLACES for k in range(_PLACES + 1)]
        rates = [*kinematics.rates, *(kinematics.jet(name, time)[1] for name in _ANGLES for time in times)]
        step = min(20.0, 0.25 / max(1e-30, *(float(abs(x)) for x in rates)))
        if case.motion == "great_circle":
            # The formulas of the great circle are singular at the poles, in time too.
            places = map(kinematics.place, times)
            step = min(step, *(0.03 * float(place.latitude[1] / _turning(kinematics, place)) for place in places))
    return step


def _turning(kinematics: Kinematics, place: Place) -> Number:
    return kinematics.speed(place) / place.radius[0]
