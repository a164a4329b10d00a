"""The mast's equations written out with matrices, and what their derivatives and their noise must be: no compiled code.

The paper's own forms are selected by the same `Terms`. Derivatives are complex steps of the plain Python model.
"""

import numpy as np

from mast_python import python_modules
from sinsbench.subjects.mast.terms import VARIANTS

__all__ = ["CONSTANTS", "NAMES", "SENSORS", "STATE", "TIME", "computed", "disagreements", "expected"]

#: Variants that between them use every coefficient; constants at which no term of the equations is small.
NAMES = ("corrected", "repaired", "printed", "printed_313", "vehicle_turn_ignored")
PYTHON = python_modules()
MODEL = PYTHON["model"]
CONSTANTS = MODEL.Constants(mast_length=5.0, earth_radius=100.0, earth_rate=0.05, gravitation=9.81)
RANDOM = np.random.default_rng(2024)
TIME, DRIVEN = 7.0, 0.3  # gyroscope 2 drives eta by 0 or 1: what is right between is right there


def unit(size):
    q = RANDOM.normal(size=size)
    return q / np.linalg.norm(q)


STATE = np.concatenate([unit(4), [0.5, 0.8], [20, 100, 1.5], [30.0], unit(4), unit(4), [0.5, 0.3]])
SENSORS = MODEL.Sensors(*[tuple(RANDOM.normal(size=3)) for _ in range(4)])
POSITION, SPEED = (90.0, 200.0, 150.0), (3.0, 4.0, -2.0)


def matrix(q):
    a, b, c, d = q
    return np.array(
        [
            [2 * a * a + 2 * b * b - 1, 2 * (b * c + a * d), 2 * (b * d - a * c)],
            [2 * (b * c - a * d), 2 * a * a + 2 * c * c - 1, 2 * (c * d + a * b)],
            [2 * (b * d + a * c), 2 * (c * d - a * b), 2 * a * a + 2 * d * d - 1],
        ]
    )


def phi(q):
    a, b, c, d = q
    return np.array([[-b, -c, -d], [a, -d, c], [d, a, -b], [-c, b, a]])


def local(angle, latitude):
    s, c, sl, cl = np.sin(angle), np.cos(angle), np.sin(latitude), np.cos(latitude)
    return np.array([[c, 0, -s], [-s * sl, cl, -c * sl], [s * cl, sl, c * cl]])


def rates(y, sensors, driven, terms, constants, t):
    """F, and H_d, the constraint: all at once."""
    w1, f1, w2, f2 = (np.array(x) for x in sensors)
    mu, lon, lat, v, height, eta, lam, w = y[:4], y[4], y[5], y[6:9], y[9], y[10:14], y[14:18], y[18:]
    r, om, g0, length = constants[1] + height, constants[2], constants[3], constants[0]
    s, c = np.sin(lat), np.cos(lat)
    b = local(lon + om * t, lat)
    m, e, d = matrix(mu), matrix(eta), matrix(lam)
    frame = m @ b.T
    upward = om**2 * r * c ** (2 if terms.upward_square else 1) - g0
    gravity = np.array([0, -(om**2) * r * c * s, upward])
    paper = np.array([0, -(om ** (2 if terms.mast_gravity_square else 1)) * r * c * s, upward])
    a = np.array([-v[1] / r, 2 * om * c + v[0] / r, 2 * om * s + v[0] * np.tan(lat) / r])
    dv = frame.T @ f1 + terms.transport * np.cross(a, v) + gravity
    u, earth, heavy = d @ w1, d @ frame @ np.array([0, om * c, om * s]), d @ frame @ paper
    carried = np.array([*w, u[2]]) + terms.relative * np.array([u[0], u[1], 0]) + terms.earth_rate_again * earth
    shown = e @ carried
    delta = e.T @ f2 - d @ f1
    k = u[2] if not terms.earth_turn else 2 * (om if terms.whole_earth_rate else earth[2])
    scale = 1 / length if terms.length_inverted else length
    dw = (
        scale * np.array([terms.mast_x * delta[1], terms.mast_y * delta[0]])
        + k * np.array([terms.turn_x * w[1], terms.turn_y * w[0]])
        + np.array([terms.gravity_x * heavy[1], terms.gravity_y * heavy[0]]) / length
    )
    relative = np.array([*(w - (0 if terms.relative else 1) * u[:2]), 0])
    full = w + (u[:2] if terms.relative else 0)
    out = np.concatenate(
        [
            phi(mu) @ w1 / 2, [v[0] / (r * c), v[1] / r], dv, [v[2]], driven * phi(eta) @ (w2 - shown) / 2,
            phi(lam) @ relative / 2, dw,
        ]
    )  # fmt: skip
    return out, shown, delta[2] + length * full @ full


def satellites(y, position, speed, terms, constants):
    lon, lat, v, r = y[4], y[5], y[6:9], constants[1] + y[9]
    d = np.array(position) - r * np.array([np.cos(lat) * np.sin(lon), np.sin(lat), np.cos(lat) * np.cos(lon)])
    rate = d @ (np.array(speed) - local(lon, lat).T @ v) / np.sqrt(d @ d)
    return rate, np.sqrt(d[0] ** 2 + d[1] ** (2 if terms.range_square else 1) + d[2] ** 2)


def derivative(function, point):
    """Complex step: exact to rounding, as nothing is subtracted."""
    columns = []
    for j in range(len(point)):
        moved = [complex(x) for x in point]
        moved[j] += 1e-30j
        columns.append(np.imag(np.atleast_1d(function(moved))) / 1e-30)
    return np.array(columns).T


def model_rates(y, sensors, driven, terms):
    out = np.zeros(20, complex)
    MODEL.state_rates(y, TIME, sensors, driven, terms, CONSTANTS, out)
    return out


def noise_expected(terms, driven):
    """F_1: true values are Z - W, so its columns are the derivatives of F by the sensors, sign reversed."""
    flat = np.concatenate(SENSORS)

    def by_sensors(z):
        sensors = MODEL.Sensors(*(tuple(z[i : i + 3]) for i in (0, 3, 6, 9)))
        return model_rates([complex(x) for x in STATE], sensors, driven, terms)

    by = -derivative(by_sensors, flat)  # columns: rate1, force1, rate2, force2
    last = by[:, 6:9] if driven else np.vstack([np.zeros((10, 3)), phi(STATE[10:14]) / 2, np.zeros((6, 3))])
    return np.hstack([by[:, :6], by[:, 9:], last])


def coupling_expected(terms, rate1, antenna, rate2):
    """Theta and S from their definitions, with H_1 = (1, -dH_d/dZ_d1, 1)."""

    def shown(z):
        return np.array(MODEL.antenna_rate(list(STATE), SENSORS._replace(rate1=tuple(z)), terms, CONSTANTS))

    through = -derivative(shown, SENSORS.rate1)
    gain = noise_expected(terms, 0.0)
    theta = gain[:, :3] * rate1 @ through.T + gain[:, 9:] * antenna
    return theta, (antenna + rate2) * np.eye(3) + rate1 * through @ through.T


def expected(name):
    """Everything that a variant's compiled functions must give at `STATE`, by name."""
    terms = VARIANTS[name].terms
    rate, shown, constraint = rates(STATE, SENSORS, DRIVEN, terms, CONSTANTS, TIME)
    found = {"axes": np.eye(3), "F": rate, "H_d": shown, "A_Z": np.array(constraint)}
    found["F_Y"] = derivative(lambda y: model_rates(y, SENSORS, DRIVEN, terms), STATE)
    found |= {f"F_1{driven}": noise_expected(terms, driven) for driven in (0.0, 1.0)}
    found["H_V"], found["H_R"] = map(np.array, satellites(STATE, POSITION, SPEED, terms, CONSTANTS))
    found["H_d,Y"] = derivative(lambda y: MODEL.antenna_rate(y, SENSORS, terms, CONSTANTS), STATE)
    found["A_Z,Y"] = derivative(lambda y: MODEL.mast_constraint(y, SENSORS, terms, CONSTANTS), STATE)[0]
    found["H_V,Y"] = derivative(lambda y: MODEL.satellite_range_rate(y, POSITION, SPEED, CONSTANTS), STATE)[0]
    found["H_R,Y"] = derivative(lambda y: MODEL.satellite_range(y, POSITION, terms, CONSTANTS), STATE)[0]
    found["Theta"], found["S"] = coupling_expected(terms, 0.3, 0.7, 0.2)
    return found


def computed(name, modules=PYTHON, only=("model", "jacobians", "disturbances")):
    """The same from the modules' own functions; `only` says whose."""
    terms, y = VARIANTS[name].terms, list(map(float, STATE))
    found = {}
    antenna = np.zeros((3, 20))
    if "model" in only:
        m = modules["model"]
        found["axes"] = np.array([m.axis(k) for k in range(3)])
        found["F"] = np.zeros(20)
        m.state_rates(y, TIME, SENSORS, DRIVEN, terms, CONSTANTS, found["F"])
        found["H_d"] = np.array(m.antenna_rate(y, SENSORS, terms, CONSTANTS))
        found["A_Z"] = np.array(m.mast_constraint(y, SENSORS, terms, CONSTANTS))
        found["H_V"] = np.array(m.satellite_range_rate(y, POSITION, SPEED, CONSTANTS))
        found["H_R"] = np.array(m.satellite_range(y, POSITION, terms, CONSTANTS))
    if "jacobians" in only:
        m = modules["jacobians"]
        m.antenna_rate_derivative(y, SENSORS, terms, CONSTANTS, antenna)
        found["F_Y"] = np.full((20, 20), 7.0)  # what stood there before must not stay
        m.state_derivative(STATE, TIME, SENSORS, DRIVEN, antenna, terms, CONSTANTS, found["F_Y"])
        found["H_d,Y"], found["A_Z,Y"], sky = antenna, np.zeros(20), np.zeros((2, 20))
        m.constraint_derivative(y, SENSORS, terms, CONSTANTS, found["A_Z,Y"])
        m.satellite_derivative(y, POSITION, SPEED, terms, CONSTANTS, sky)
        found["H_V,Y"], found["H_R,Y"] = sky
    if "disturbances" in only:
        m = modules["disturbances"]
        for driven in (1.0, 0.0):
            found[f"F_1{driven}"] = np.full((20, 12), 7.0)
            m.noise_gain(y, TIME, driven, terms, CONSTANTS, found[f"F_1{driven}"])
        found["Theta"], inverse = np.zeros((20, 3)), np.zeros((3, 3))
        m.shared_noise(y, found["F_10.0"], 0.3, 0.7, 0.2, terms, found["Theta"], inverse)
        found["S"] = np.linalg.inv(inverse)
    return found


def disagreements(name, reference, modules=PYTHON, only=("model", "jacobians", "disturbances")):
    """Names of what is not as expected, to 1e-11 of the largest element: sums of a few dozen roundings."""
    found = computed(name, modules, only)
    return [
        key for key, value in found.items()
        if not np.abs(value - reference[key]).max() <= 1e-11 * max(1.0, np.abs(reference[key]).max())
    ]  # fmt: skip
