"""The gyroscopic systems as data: what each is, how it starts, what it shows, and when its equations hold.

Importing this module compiles nothing; `sinsbench.subjects.gyroscopic.drivers` does that on demand.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.gyroscopic import start_rules as rules
from sinsbench.subjects.gyroscopic.contract import BrokenConditionError, Start
from sinsbench.subjects.gyroscopic.equations import Constants

__all__ = ["SYSTEMS", "Aid", "System", "constants"]

Array = NDArray[np.float64]
Tuning = Callable[[Start], float]
Observation = Callable[[Array, Constants], dict[str, Array]]

ROTOR_MOMENTUM = 1000.0
"""B of the two-rotor frame with m l = 1 kg m, kg m^2/s: the speed must stay below 2B/(m l) = 2000 m/s."""


def _schuler_tuning(start: Start) -> float:
    """Return kappa = 1/sqrt(g R)."""
    return 1 / start.schuler_speed


def _speed_tuning(start: Start) -> float:
    """Return kappa = 1/sqrt(g R - v^2), exact at constant speed."""
    if start.speed >= start.schuler_speed:
        raise BrokenConditionError("absolute speed < sqrt(g R)", 0.0)
    return float(1 / np.sqrt(start.schuler_speed**2 - start.speed**2))


def constants(start: Start, tuning: Tuning = _schuler_tuning, factor: float = 1.0) -> Constants:
    """Return the constants of a system tuned to a sphere.

    Parameters
    ----------
    start : Start
        Its radius, gravity and speed.
    tuning : callable
        Tuning kappa of a gyropendulum of constant momentum.
    factor : float
        Multiplies kappa: a system out of tune.

    Returns
    -------
    Constants
        m l = 1 kg m, n = 1/(m l R); the linear spring is the tangent of the unperturbed law at the start speed.
    """
    momentum, radius = 2 * ROTOR_MOMENTUM, start.radius
    angle = np.arccos(min(start.speed / momentum, 1.0))
    slope = -(momentum**2) / radius * np.cos(2 * angle)
    offset = -(momentum**2) / radius * np.sin(angle) * np.cos(angle) - slope * angle
    return Constants(
        radius=radius,
        gravity=start.gravity,
        tuning=factor * tuning(start),
        pendulosity=1.0,
        rotor_momentum=ROTOR_MOMENTUM,
        inverse_inertia=1 / radius,
        moment_offset=float(offset),
        moment_slope=float(slope),
    )


def _unit(vectors: Array) -> Array:
    result: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return result


def third_axis(quaternions: Array) -> Array:
    """Return the third new axis in the old ones, shape (n, 3), of quaternions (n, 4) of any norm."""
    w, x, y, z = quaternions.T
    return _unit(np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z]))


def _trihedron(states: Array, _: Constants) -> dict[str, Array]:
    quaternions = states[:, :4]
    return {"vertical": third_axis(quaternions), "trihedron": _unit(quaternions)}


def _with_speed(speed: Callable[[Array, Constants], Array]) -> Observation:
    return lambda states, k: _trihedron(states, k) | {"speed": speed(states, k)}


def _pair(paper_scale: bool) -> Observation:
    """Bisector of the axes p, n of two gyropendulums, and the speed from the angle between them."""

    def observe(states: Array, k: Constants) -> dict[str, Array]:
        p, n = third_axis(states[:, :4]), third_axis(states[:, 4:8])
        y3, y2, half = _unit(p + n), _unit(p - n), np.linalg.norm(p - n, axis=1) / 2
        axes = np.stack([np.cross(y2, y3), y2, y3], axis=1)
        angle = np.arcsin(np.minimum(half, 1.0)) if paper_scale else half
        return {
            "vertical": y3,
            "trihedron": rules.quaternions_of_axes(axes),
            "speed": np.sqrt(k.gravity * k.radius) * angle,
        }

    return observe


def _deviated(states: Array, _: Constants) -> dict[str, Array]:
    """Show e = nu o lambda of the reference trihedron and the deviation from it."""
    trihedron = _unit(rules.products(states[:, :4], states[:, 4:8]))
    return {"vertical": third_axis(trihedron), "trihedron": trihedron}


def _position(states: Array, k: Constants) -> dict[str, Array]:
    """Vertical, a trihedron of any azimuth about it, speed and distance from the centre."""
    vertical = _unit(states[:, :3])
    # The turn about a horizontal axis that takes X3 to the vertical; half the way is the bisector.
    x, y, z = vertical.T
    bisector = np.column_stack([1 + z, -y, x, np.zeros_like(x)])
    bisector[z <= -1] = [0.0, 1.0, 0.0, 0.0]
    across = states[:, 3:6] - vertical * np.sum(vertical * states[:, 3:6], axis=1, keepdims=True)
    return {
        "vertical": vertical,
        "trihedron": _unit(bisector),
        "speed": np.linalg.norm(across, axis=1),
        "radius": np.linalg.norm(states[:, :3], axis=1),
    }


class Aid(NamedTuple):
    """An input of a system besides the sensors.

    Attributes
    ----------
    name : str
        Name among the aiding inputs; empty for one that is never read from there.
    default : callable or None
        What stands for it where it is not given; None where it must be.
    """

    name: str
    default: Callable[[Constants], float] | None = None


@dataclass(frozen=True)
class System:
    """A gyroscopic system, or a system it is compared with.

    Attributes
    ----------
    name : str
        Name in `sinsbench.subjects.gyroscopic.catalogue.CATALOGUE`, which says what it is.
    right_hand_side, condition : str
        Names in `sinsbench.subjects.gyroscopic.equations`.
    requirement : str
        The condition in words.
    quaternions : int
        Number of quaternions at the head of the state.
    start : callable
        Rule of `sinsbench.subjects.gyroscopic.start_rules`.
    observe : callable
        Takes states (m + 1, n) and constants; returns ``vertical`` (m + 1, 3) and ``trihedron`` (m + 1, 4) in X, and
        ``speed`` (m + 1,), m/s, where the system tells it.
    aids : tuple of Aid
        What the right-hand side finds in its argument ``aid``.
    vectors : tuple of int
        Lengths of the vectors that the numbers behind the quaternions make.
    tuning : callable
        Tuning kappa from the start.
    exact : bool
        Whether, without errors, its vertical is the true one for any motion on a sphere of constant radius.
    """

    name: str
    right_hand_side: str
    quaternions: int
    start: rules.StartRule
    observe: Observation
    condition: str = "unconditional"
    requirement: str = "the state is finite"
    aids: tuple[Aid, ...] = ()
    vectors: tuple[int, ...] = (1,)
    tuning: Tuning = _schuler_tuning
    exact: bool = False


def _zero(_: Constants) -> float:
    return 0.0


def _vector(name: str, default: Callable[[Constants], float] | None = _zero) -> tuple[Aid, Aid, Aid]:
    x, y, z = (Aid(f"{name}_{axis}", default) for axis in "xyz")
    return x, y, z


_CONSTANT_RADIUS = (Aid("", lambda k: k.radius), Aid("", _zero))
_MOMENT, _SPIN = _vector("moment"), Aid("spin", _zero)
_ARM = (Aid("arm_x", _zero), Aid("arm_y", _zero), Aid("arm_z", lambda k: -k.pendulosity))
_REFERENCE = _vector("reference_rate", None)

_COMPASS = ("gyrohorizoncompass", 1, rules.compass, _with_speed(lambda x, _: x[:, 4]), "first_number_positive", "h > 0")
_FRAME = (
    1,
    rules.two_rotor_frame,
    _with_speed(lambda x, k: 2 * k.rotor_momentum / k.pendulosity * np.cos(x[:, 4])),
    "frame_open",
    "0 < E < pi/2, that is 0 < v < 2B/(m l),",
)
_APART = ("axes_apart_from_opposite", "|p + n| > 0")
_MOMENTUM = ("first_number_positive", "H > 0")
_SPEED = ("below_schuler_speed", "absolute speed < sqrt(g R)", (Aid("speed"),))

_SYSTEMS = (
    System("gp_paper", "gyropendulum", 1, rules.pendulum(rules.paper_inclination), _trihedron),
    System("gp_equilibrium", "gyropendulum", 1, rules.pendulum(rules.equilibrium_inclination), _trihedron),
    System("gpx", "gyropendulum_programmed", 1, rules.pendulum(rules.exact_inclination), _trihedron, *_SPEED),
    System("bg_paper", "bi_gyro", 2, rules.pendulum_pair(rules.paper_inclination), _pair(True), *_APART),
    System("bg_equilibrium", "bi_gyro", 2, rules.pendulum_pair(rules.equilibrium_inclination), _pair(True), *_APART),
    System(
        "bgx", "bi_gyro_self_tuned", 2, rules.pendulum_pair(rules.exact_inclination), _pair(False), *_APART, exact=True
    ),
    System(
        "bgv", "bi_gyro", 2, rules.pendulum_pair(rules.exact_inclination), _pair(False), *_APART, tuning=_speed_tuning
    ),
    System("gf", "gyroframe", *_FRAME, exact=True),
    System("gf_linear", "gyroframe_linear", *_FRAME),
    System("ghc", *_COMPASS, _CONSTANT_RADIUS, exact=True),
    System("ghc_radius", *_COMPASS, (Aid("radius"), Aid("", _zero)), exact=True),
    System("ghc_altitude", *_COMPASS, (Aid("radius"), Aid("radius_rate")), exact=True),
    System(
        "full",
        "full_equations",
        0,
        rules.momentum_of_motion,
        _with_speed(lambda x, k: 2 * k.radius * np.linalg.norm(x[:, 4:8], axis=1)),
        aids=_MOMENT,
        vectors=(4, 4),
        exact=True,
    ),
    System(
        "trad",
        "two_component",
        1,
        rules.azimuth_free,
        _with_speed(lambda x, _: np.hypot(x[:, 4], x[:, 5])),
        aids=_CONSTANT_RADIUS,
        vectors=(2,),
        exact=True,
    ),
    System(
        "newton",
        "newton",
        0,
        rules.position_and_velocity,
        _position,
        "away_from_centre",
        "|r| > 0",
        vectors=(3, 3),
        exact=True,
    ),
    System(
        "gp_moments",
        "gyropendulum_moments",
        1,
        rules.with_momentum(rules.pendulum(rules.paper_inclination)),
        _trihedron,
        *_MOMENTUM,
        (*_MOMENT, _SPIN),
    ),
    System(
        "gyroscope_general",
        "gyroscope_general",
        1,
        rules.with_momentum(rules.pendulum(rules.paper_inclination)),
        _trihedron,
        *_MOMENTUM,
        (*_MOMENT, _SPIN, *_ARM),
    ),
    System("gf_moments", "gyroframe_moments", 1, rules.momentum_frame, _trihedron, *_MOMENTUM, (*_MOMENT, Aid("spin"))),
    System(
        "deviation",
        "deviation",
        2,
        rules.deviation(rules.paper_inclination),
        _deviated,
        aids=(*_REFERENCE, *_vector("gyro_rate", None)),
    ),
    System(
        "gp_deviation",
        "gyropendulum_deviation",
        2,
        rules.with_momentum(rules.deviation(rules.paper_inclination)),
        _deviated,
        "second_number_positive",
        "H > 0",
        (*_REFERENCE, *_MOMENT),
    ),
)

SYSTEMS: Mapping[str, System] = {system.name: system for system in _SYSTEMS}
"""The systems by name."""
