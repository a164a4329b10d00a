"""The differential equations behind `gyro_systems`: attitude from the rates, Newton's equation, gyropendulums.

What is integrated knows the sensors as functions of time, and where the motion starts; place and attitude at any later
time come out of the equations: 2 s' = s o Omega, r'' = s o a o conj(s) - g R^2 r/|r|^3, p' = kappa p x a.

Source: Chelnokov 1991, eq. (1.14), (2.6), (2.8).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi

from sinsdata.cases import GyroCase
from sinsref.arithmetic import Arithmetic, BallArithmetic, Number
from sinsref.elementary import angle
from sinsref.gyroscopic import Kinematics, elementary, half_turn
from sinsref.gyroscopic_systems import axis_rate, bisector, start, usual_tuning
from sinsref.quaternion import dot, product, rotate

#: Widths of the vectors in the columns of each table: a vector is compared by its norm.
VECTORS: Mapping[str, Sequence[int]] = {
    "sensors": (3, 3, 3, 3),
    "truth": (3, 2, 1, 3, 3, 3, 4, 4),
    "reference": (3,) * 6,
}


class GyroscopicProblem:
    """Field, start and rows of a case; the state is time, attitude, position, velocity, integrals, four axes.

    Parameters
    ----------
    ar : BallArithmetic
    case : GyroCase
    """

    def __init__(self, ar: BallArithmetic, case: GyroCase) -> None:
        self._ar, self._motion = ar, case.model
        self._kinematics = Kinematics(ar, case.model)
        _, self._kappa = usual_tuning(ar, case.model)
        zero = ar.number(0)
        place, begin = self._kinematics.place(zero), start(ar, case.model)
        attitude = self._kinematics.attitude(place, zero)
        position = [x * place.radius[0] for x in place.vertical]
        velocity = place.from_local(place.velocity)
        self.initial = [zero, *attitude, *position, *velocity, *[zero] * 6, *begin.paper, *begin.equilibrium]

    def field(self, ar: Arithmetic, state: Sequence[Number]) -> list[Number]:
        """Return the derivative of a state."""
        kinematics = Kinematics(ar, self._motion)
        sensors = kinematics.sensors(kinematics.place(state[0]), state[0])
        turning = [x / 2 for x in product(state[1:5], [ar.number(0), *sensors[:3]])]
        force, position = rotate(state[1:5], sensors[3:]), state[5:8]
        square = dot(position, position)
        pull = kinematics.gravity * kinematics.radius * kinematics.radius / (square * ar.sqrt(square))
        falling = [a - pull * x for a, x in zip(force, position, strict=True)]
        rates = [ar.number(1), *turning, *state[8:11], *falling, *sensors]
        for number, first in enumerate(range(17, 29, 3)):
            rates += axis_rate(-self._kappa if number % 2 else self._kappa, state[first : first + 3], force)
        return rates

    def values(self, state: Sequence[Number], before: Sequence[Number]) -> Mapping[str, Sequence[Number]]:
        """Return the rows of an epoch from its state and from that before."""
        ar, kinematics, time = self._ar, self._kinematics, state[0]
        increments = [x - y for x, y in zip(state[11:17], before[11:17], strict=True)]
        pairs = (state[17:23], state[23:])
        return {
            "sensors": [*kinematics.sensors(kinematics.place(time), time), *increments],
            "truth": self._truth(time, state[1:5], state[5:8], state[8:11]),
            "reference": [x for pair in pairs for x in (*pair, *bisector(ar, pair[:3], pair[3:]))],
        }

    def _truth(
        self, time: Number, attitude: Sequence[Number], position: Sequence[Number], velocity: Sequence[Number]
    ) -> list[Number]:
        ar, kinematics = self._ar, self._kinematics
        radius = ar.sqrt(dot(position, position))
        vertical = [x / radius for x in position]
        level = ar.sqrt(vertical[0] * vertical[0] + vertical[2] * vertical[2])
        sine, cosine = vertical[0] / level, vertical[2] / level
        latitude, principal = angle(ar, vertical[1], level), angle(ar, sine, cosine)
        # Whole turns, which the position does not tell, are those of the motion.
        _, turned = kinematics.coordinates(kinematics.place(time), time)
        longitude = principal + ar.pi * 2 * round(float(turned - principal) / (2 * pi))
        east = velocity[0] * cosine - velocity[2] * sine
        north = velocity[1] * level - vertical[1] * (velocity[0] * sine + velocity[2] * cosine)
        speed = ar.sqrt(east * east + north * north)
        half_cosine, half_sine = half_turn(ar, north / speed, east / speed)
        zero = ar.number(0)
        axes = product(elementary(ar, 2, longitude), elementary(ar, 1, -latitude))
        return [
            *(latitude, longitude, longitude - kinematics.rotation_rate * time),
            *(radius, dot(velocity, vertical), speed, *velocity, *vertical),
            *(kinematics.jet(name, time)[0] for name in ("heading", "pitch", "roll")),
            *attitude,
            *product(axes, [half_cosine, zero, zero, half_sine]),
        ]
