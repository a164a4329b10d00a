"""Motions along the equator, and errors of the subjects there, measured against the exponential in ball arithmetic."""

import numpy as np

import equator_truth
from equator_truth import NO_MISALIGNMENT
from sinsbench.subjects.equator_model import EARTH_RADIUS, EARTH_RATE

EPS = float(np.finfo(np.float64).eps)
INITIAL = (0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7)  # the initial errors (24) of the paper
FIGHTER, SHIP = (600.0, 10000.0), (10.0, 0.0)  # the two motions of the paper: v_E in m/s, H in m
STATIONARY = -EARTH_RATE * EARTH_RADIUS  # omega_N = 0
V_MAX = 7446.951262516  # a_H = 0 eastward
GENERAL = ((3e-4, -1e-4, 2e-4), (5e-5, -2e-4, 1.5e-4), (-2.5e-4, 4e-4, 1e-4))  # a misalignment, rad
LONGITUDE = 0.7  # inertial longitude at t = 0, rad

SINGULAR = {  # speeds at H = 0 where a formula, or the motion itself, degenerates
    "at rest": 0.0,
    "omega_N = 0": STATIONARY,
    "1 mm/s from omega_N = 0": STATIONARY + 1e-3,
    "1 m/s from omega_N = 0": STATIONARY + 1,
    "2u + v/R = 0": 2 * STATIONARY,
    "1 m/s below a_H = 0": V_MAX - 1,
    "1 um/s below a_H = 0": V_MAX - 1e-6,
    "a_H = 0": V_MAX,
    "1 m/s beyond a_H = 0": V_MAX + 1,
    "negative rho": 7700.0,
    "rho_1 = rho_2": 7941.571244,
    "just beyond rho_1 = rho_2": 7941.6,
    "complex rho": 8000.0,
    "fast complex rho": 12000.0,
    "a_H = 0 westward": -8376.9,
    "beyond a_H = 0 westward": -8380.0,
    "complex rho westward": -9000.0,
    "omega = omega_N": 7433.276470,
    "omega = -omega_N": -8363.224591,
    "2 omega_N = mu": 3644.262041,
    "2 omega_N = -mu": -4574.210162,
}
MOTIONS = {"fighter": FIGHTER, "ship": SHIP} | {name: (speed, 0.0) for name, speed in SINGULAR.items()}


def scales(v_east, height):
    R = 6378245.0 + height
    speed = 6378245.0 * np.sqrt(9.78049 / R)
    return np.array([speed, speed, speed, R, 1.0, 1.0])


def exact_matrix(motion, time):
    """P(t), the rows as lists of balls."""
    return equator_truth.leading_block(equator_truth.exponential(*motion, time))


def as_floats(rows):
    return np.array([[float(x) for x in row] for row in rows])


def matrix_error(matrix, motion, time):
    """Error of P(t) in natural units (velocities by sqrt(gR), heights by R), relative to P(t)."""
    exact, scale = exact_matrix(motion, time), scales(*motion)
    error = np.array([equator_truth.differences(*rows) for rows in zip(matrix, exact, strict=True)])
    weight = scale / scale[:, None]
    return np.linalg.norm(error * weight) / np.linalg.norm(as_floats(exact) * weight)


def exact_state(motion, time, initial=INITIAL, misaligned=False):
    misalignment = GENERAL if misaligned else NO_MISALIGNMENT
    return equator_truth.state(*motion, time, initial, misalignment, LONGITUDE)


def state_error(state, motion, time, initial=INITIAL, misaligned=False):
    """Error of the state in natural units, relative to the state.

    The forcing is a_H Lambda, and a_H = g - 2uv - v^2/R carries the rounding of g however small it is.
    Under a misalignment the response to a forcing g Lambda is thus added to the size it is compared with.
    """
    exact, scale = exact_state(motion, time, initial, misaligned), scales(*motion)
    size = np.linalg.norm(np.array([float(x) for x in exact]) / scale)
    if misaligned:
        response = np.array(equator_truth.differences(exact_state(motion, time, initial), exact))
        ratio = 9.78049 / float(equator_truth.constants(*motion).force)
        size += np.linalg.norm(response * ratio / scale)
    return np.linalg.norm(equator_truth.differences(state, exact) / scale) / size


def end_state(subject, motion, time=7200.0, misaligned=False):
    lead = {"misalignment": GENERAL, "inertial_longitude": LONGITUDE} if misaligned else {}
    return subject([time], *motion, INITIAL, **lead)[-1]
