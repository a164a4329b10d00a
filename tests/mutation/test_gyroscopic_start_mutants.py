"""Defects planted in how gyroscopic systems start and in their read-out must be found."""

from dataclasses import replace

import numpy as np

from gyroscopic_laws import THIRD, quaternion
from gyroscopic_motions import conjugate, product, turned
from gyroscopic_mutants import unseen
from sinsbench.subjects.gyroscopic import read_out, start_rules
from sinsbench.subjects.gyroscopic.contract import BrokenConditionError, Start
from sinsbench.subjects.gyroscopic.equations import Constants

ROUNDING = 1e-12
CONSTANTS = Constants(
    radius=1.7, gravity=2.3, tuning=0.6, pendulosity=1.9, rotor_momentum=1.6, inverse_inertia=0.45,
    moment_offset=0.7, moment_slope=-1.3,
)  # fmt: skip
#: Speeds of order 1 beside sqrt(g R) = 2: every power of v/V is visible.
START = Start(quaternion(5), THIRD, np.array([0.3, -0.4, 0.6]), 1.7, 2.3, 0.35)
BASIS = np.eye(3)
#: Rotations in which each component of the quaternion is the largest, and those in which it is the only one.
ROTATIONS = np.array([
    *np.eye(4), [0.8, 0.3, -0.4, 0.2], [0.2, 0.9, 0.3, -0.1], [-0.3, 0.2, 0.9, 0.1], [0.1, -0.4, 0.3, 0.8],
    [0.02, 0.7, 0.71, 0.01], [0.01, 0.02, 0.7, 0.71], [0.7, 0.01, 0.02, 0.71], [0.01, 0.71, 0.02, 0.7],
    [0.71, 0.7, 0.01, 0.02], [0.7, 0.02, 0.71, 0.01],
])  # fmt: skip
ROTATIONS /= np.linalg.norm(ROTATIONS, axis=1, keepdims=True)


def close(*pairs):
    return all(np.allclose(x, y, rtol=ROUNDING, atol=ROUNDING) for x, y in pairs)


def same_rotation(q, other):
    return np.allclose(q * np.sign(np.sum(q * other, -1, keepdims=True)), other, rtol=ROUNDING, atol=ROUNDING)


def refuses(call, condition, time=0.0):
    try:
        call()
    except BrokenConditionError as error:
        return error.condition == condition and error.time == time
    return False


def axes(q):
    return np.array([turned(q, axis) for axis in BASIS])


def frame(start):
    """Velocity, left of it, up."""
    level = start.velocity - (start.velocity @ start.vertical) * start.vertical
    y1 = level / np.linalg.norm(level)
    return np.linalg.norm(level), np.array([y1, np.cross(start.vertical, y1), start.vertical])


def rests(alpha, kappa, v, turn):
    """Omega x eta = kappa eta x a in the trihedron of constant speed and turn."""
    eta = np.array([0.0, -np.sin(alpha), np.cos(alpha)])
    omega, force = np.array([0.0, v / 1.7, turn]), np.array([0.0, v * turn, 2.3 - v * v / 1.7])
    return close((np.cross(omega, eta), kappa * np.cross(eta, force))) and abs(alpha) < np.pi / 2


def starts_are_right(module, name):
    k, (v, y) = CONSTANTS, frame(START)
    first, second = np.array([quaternion(8), quaternion(9)]), np.array([quaternion(10), quaternion(11)])
    vectors = np.array([[0.3, -0.7, 0.2], [0.5, 0.1, -0.9]])
    if not same_rotation(module.quaternions_of_axes(np.array([axes(q) for q in ROTATIONS])), ROTATIONS):
        return False
    if not close((module.products(first, second), product(first, second))):
        return False
    if not close((module.rotated(first, vectors), turned(first, vectors))):
        return False
    paper, exact, even = (
        getattr(module, f"{rule}_inclination")(START, k) for rule in ("paper", "exact", "equilibrium")
    )
    sine = -v / np.sqrt(2.3 * 1.7)
    if not close((paper, (-0.6 * v, 0.6 * v)), (np.sin(exact), (sine, -sine))):
        return False
    if not (rests(even[0], 0.6, v, 0.35) and rests(even[1], -0.6, v, 0.35)):
        return False
    alpha = even[0]
    inclined = np.array(
        [y[0], np.cos(alpha) * y[1] + np.sin(alpha) * y[2], np.cos(alpha) * y[2] - np.sin(alpha) * y[1]]
    )
    pair = module.pendulum_pair(module.equilibrium_inclination)(START, k)
    other = np.cos(even[1]) * y[2] - np.sin(even[1]) * y[1]
    single = module.with_momentum(module.pendulum(module.equilibrium_inclination))(START, k)
    deviated = module.deviation(module.equilibrium_inclination)(START, k)
    frames = {rule: getattr(module, rule)(START, k) for rule in ("momentum_frame", "compass", "two_rotor_frame")}
    free, full, newton = (
        getattr(module, rule)(START, k) for rule in ("azimuth_free", "momentum_of_motion", "position_and_velocity")
    )
    level = v * y[0]
    if not close(
        (axes(single[:4]), inclined), (single[4:], [1.9 / 0.6]), (axes(pair[:4]), inclined),
        (turned(pair[4:], BASIS[2]), other), (axes(deviated[:4]), y),
        (axes(product(deviated[:4], deviated[4:])), inclined),
        *((axes(state[:4]), y) for state in frames.values()),
        (frames["momentum_frame"][4:], [1.9 * v]), (frames["compass"][4:], [v]),
        (3.2 * np.cos(frames["two_rotor_frame"][4:]), [1.9 * v]),
        (axes(free[:4]), y), (free[4:], [v, 0.0]),
        (axes(full[:4]), y), (2 * product(full[4:], conjugate(full[:4])), [0.0, *(np.cross(THIRD, level) / 1.7)]),
        (newton, [*(1.7 * THIRD), *START.velocity]),
        (module.position_and_velocity(replace(START, distance=2.5), k)[:3], 2.5 * THIRD),
    ):  # fmt: skip
        return False
    resting = replace(START, velocity=0.3 * THIRD)
    for rule in (module.azimuth_free, module.momentum_of_motion):
        state = rule(resting, k)
        if not close((turned(state[:4], BASIS[2]), THIRD), (state[4:], 0.0), (np.linalg.norm(state[:4]), 1.0)):
            return False
    # Along the first axis, by a number: at the limit, a thousandth below and a thousandth above.
    limit = np.sqrt(2.3 * 1.7)
    along = [replace(START, vertical=BASIS[2], velocity=speed * BASIS[0]) for speed in (0.9995, 1.0005)]
    slow, fast = (replace(x, velocity=limit * x.velocity) for x in along)
    open_, shut = (replace(x, velocity=3.2 / 1.9 * x.velocity) for x in along)
    module.exact_inclination(slow, k), module.two_rotor_frame(open_, k)
    return (
        refuses(lambda: module.exact_inclination(fast, k), "absolute speed < sqrt(g R)")
        and refuses(lambda: module.two_rotor_frame(shut, k), "absolute speed < 2B/(m l)")
        and refuses(
            lambda: module.two_rotor_frame(replace(open_, velocity=3.2 / 1.9 * BASIS[0]), k._replace(pendulosity=1.9)),
            "absolute speed < 2B/(m l)",
        )
    )


#: Which of the four forms of a quaternion is used: of a rotation, the defects choose no form that divides by zero.
ANOTHER_FORM = tuple(f"_quaternions_of_axes: {condition}" for condition in ("trace >=", "x[0] >=", "y[1] >="))


def test_every_defect_in_the_rules_of_the_start_is_found():
    found, planted = unseen(start_rules, starts_are_right, left_out=("Array", "StartRule", "Inclination"))
    assert [place for place in found if not place.startswith(ANOTHER_FORM)] == []
    assert planted > 200


# The read-out


def elementary(axis, angle):
    q = np.zeros(4)
    q[0], q[axis] = np.cos(angle / 2), np.sin(angle / 2)
    return q


def attitude_of(latitude, longitude, heading, pitch, roll):
    place = product(elementary(2, longitude), elementary(1, -latitude))
    s = place
    for axis, angle in ((3, -heading), (1, pitch), (2, roll)):
        s = product(s, elementary(axis, angle))
    return place, s


ANGLES = np.array([
    [0.7, 2.5, 0.4, -0.6, 0.9], [-1.1, -2.0, 5.5, 1.2, -2.6], [0.3, -0.8, 2.9, -1.3, 2.2], [-0.2, 1.4, 4.0, 0.1, -0.7],
])  # fmt: skip


def angles_are_right(module, name):
    places, attitudes = map(np.array, zip(*(attitude_of(*row) for row in ANGLES), strict=True))
    turned_places = product(places, np.array([elementary(3, angle) for angle in (0.4, -2.0, 3.0, 1.7)]))
    computed = module.read_out(-3 * turned_places, 2 * attitudes, np.arange(4.0))
    if list(computed) != ["latitude", "longitude_absolute", "heading", "pitch", "roll"]:
        return False
    if not close((np.array(list(computed.values())).T, ANGLES)):
        return False
    for angle, condition in ((0, "latitude away from the poles"), (3, "pitch away from 90 deg")):
        for near, refused in ((1.0005e-7, False), (0.9995e-7, True)):
            given = ANGLES[:2].copy()
            given[1, angle] = np.pi / 2 - near
            e, s = map(np.array, zip(*(attitude_of(*row) for row in given), strict=True))
            if refused and not refuses(lambda e=e, s=s: module.read_out(e, s, [3.0, 7.0]), condition, 7.0):
                return False
            if not refused:
                module.read_out(e, s, [3.0, 7.0])
    for zero in (0, 1):
        given = [places.copy(), attitudes.copy()]
        given[zero][2] = 0
        try:
            module.read_out(*given, np.arange(4.0))
        except ValueError as error:
            if "a quaternion is zero" not in str(error):
                return False
        else:
            return False
    return True


def test_every_defect_in_the_read_out_is_found():
    found, planted = unseen(read_out, angles_are_right, left_out=("Array",))
    assert found == []
    assert planted > 100
