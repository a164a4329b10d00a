"""A small simulation of the mast's scenario in double precision: what the filters' tests run on.

It shares no code with the truth of the dataset: Magnus steps of order 6, noise by counters, both as in Sokolov,
Pogorelov, Reshetnikova 2024 with our choices where the paper is silent.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from sinsbench.subjects.mast.contract import MastConstants, MastInputs, MastNoise, MastStart

__all__ = ["ANTENNA", "GRADES", "Run", "errors", "simulated"]

STEP, R, RE, OM, G = 0.01, 5.0, 6371000.0, 7.292115e-5, 9.81
ANTENNA = 1e-2
GRADES = {"G1": (0.1, 5.0), "G2": (0.01, 1.0), "G3": (0.001, 0.1)}
NODES = np.deg2rad([(0, 60), (60, 10), (330, 100), (250, 140)])
GOLDEN, FIRST, SECOND = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB
SDS = np.array(
    [*[0.01 / 3**0.5] * 3, 3 / RE / np.cos(np.pi / 4), 3 / RE, *[0.05] * 3, 3.0, *[0.01 / 3**0.5] * 5, 0.0, *[5e-3] * 2]
)


class Run(NamedTuple):
    inputs: MastInputs
    start: MastStart
    truth: dict


def mixed(z):
    z = np.asarray(z, np.uint64)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(FIRST)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(SECOND)
    return z ^ (z >> np.uint64(31))


def normal(seed, stream, count):
    """`count` standard normal numbers of a stream."""
    pairs = (count + 1) // 2
    k = np.arange(2 * pairs, dtype=np.uint64)
    counter = (k + np.uint64((stream << 40) + 1)) * np.uint64(GOLDEN) + mixed(np.array([seed], np.uint64))[0]
    u = ((mixed(counter) >> np.uint64(11)).astype(float) + 0.5) / 2**53
    radius, angle = np.sqrt(-2 * np.log(u[0::2])), 2 * np.pi * u[1::2]
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]).ravel()[:count]


def product(a, b):
    a, b = np.broadcast_arrays(a, b)
    a0, a1, a2, a3 = np.moveaxis(a, -1, 0)
    b0, b1, b2, b3 = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
            a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
            a0 * b2 + a2 * b0 + a3 * b1 - a1 * b3,
            a0 * b3 + a3 * b0 + a1 * b2 - a2 * b1,
        ],
        axis=-1,
    )


def turn(v):
    """Quaternion of a rotation vector."""
    angle = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), np.sinc(angle / (2 * np.pi)) / 2 * v], axis=-1)


def conj(q):
    return q * [1, -1, -1, -1]


def matrix(q):
    """D(q)."""
    a, b, c, d = np.moveaxis(q, -1, 0)
    rows = [
        [2 * a * a + 2 * b * b - 1, 2 * (b * c + a * d), 2 * (b * d - a * c)],
        [2 * (b * c - a * d), 2 * a * a + 2 * c * c - 1, 2 * (c * d + a * b)],
        [2 * (b * d + a * c), 2 * (c * d - a * b), 2 * a * a + 2 * d * d - 1],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def chained(q, turns):
    """q, q o turns[0], q o turns[0] o turns[1], ... by doubling."""
    out = np.concatenate([q[None], turns])
    shift = 1
    while shift < len(out):
        out[shift:] = product(out[:-shift], out[shift:])
        shift *= 2
    return out / np.linalg.norm(out, axis=1, keepdims=True)


def magnus(rate, q, times):
    """Solve q' = 1/2 q o rate by Magnus steps of order 6 between equidistant times."""
    h = times[1] - times[0]
    nodes = [0.5 - 15**0.5 / 10, 0.5, 0.5 + 15**0.5 / 10]
    a, b, c = (-rate(times[:-1] + x * h) / 2 for x in nodes)

    def bracket(x, y):
        return 2 * np.cross(x, y)

    first, second, third = h * b, 15**0.5 * h / 3 * (c - a), 10 * h / 3 * (c - 2 * b + a)
    c1 = bracket(first, second)
    c2 = -bracket(first, 2 * third + c1) / 60
    omega = first + third / 12 + bracket(-20 * first - third + c1, second + c2) / 240
    return chained(q, turn(-2 * omega))


def vehicle_rate(t):
    return np.stack([1e-1 * np.cos(3 * t), 1e-3 * np.cos(4 * t), 1.5e-2 * np.cos(7 * t)], axis=-1)


def mast_rate(t):
    return np.stack([0.43 * np.cos(2.45 * t), 0.3 * np.cos(2.7 * t), 0 * t], axis=-1)


def latitude(t):
    q, r0 = 0.02, RE + 3
    i0 = 100 * t + (1 - np.cos(q * t)) / q
    i1 = 150 * (1 - np.cos(t)) + 0.75 * (np.sin((1 - q) * t) / (1 - q) - np.sin((1 + q) * t) / (1 + q))
    i2 = (
        225 * (t / 2 - np.sin(2 * t) / 4)
        + 1.125 * (1 - np.cos(q * t)) / q
        - 0.5625 * ((1 - np.cos((q + 2) * t)) / (q + 2) + (1 - np.cos((q - 2) * t)) / (q - 2))
    )
    return np.pi / 4 + i0 / r0 - i1 / r0**2 + i2 / r0**3


def local_axes(lon, lat):
    s, c, z = np.sin(lon), np.cos(lon), 0 * lon
    sl, cl = np.sin(lat), np.cos(lat)
    rows = [[c, z, -s], [-s * sl, cl, -c * sl], [s * cl, sl, c * cl]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def apply(m, v):
    return np.einsum("...ij,...j->...i", m, v)


@cache
def motion(duration):
    """What no seed changes, on the half grid: mu, lambda, latitude, height, velocity, w, f1, f2 in Q, satellites."""
    t = np.arange(2 * round(duration / STEP) + 1) * (STEP / 2)
    zero = 0 * t
    lon0 = np.pi / 6
    q2 = np.array([np.cos(lon0 / 2), 0, np.sin(lon0 / 2), 0])
    q1 = np.array([np.cos(np.pi / 8), -np.sin(np.pi / 8), 0, 0])
    mu = magnus(vehicle_rate, product(q2, q1), t)
    lam = magnus(mast_rate, np.array([1.0, 0, 0, 0]), t)
    lat, height = latitude(t), 3 + 1.5 * np.sin(t)
    v = np.stack([zero, 100 + np.sin(0.02 * t), 1.5 * np.cos(t)], axis=-1)
    dv = np.stack([zero, 0.02 * np.cos(0.02 * t), -1.5 * np.sin(t)], axis=-1)
    r = RE + height
    a = np.stack([-v[:, 1] / r, 2 * OM * np.cos(lat), 2 * OM * np.sin(lat)], axis=-1)
    g = np.stack([zero, -(OM**2) * r * np.cos(lat) * np.sin(lat), OM**2 * r * np.cos(lat) ** 2 - G], axis=-1)
    inertial = local_axes(lon0 + OM * t, lat)
    f1 = apply(matrix(mu), apply(np.swapaxes(inertial, 1, 2), dv + np.cross(a, v) - g))
    w1, wq = vehicle_rate(t), mast_rate(t)
    dw1 = np.stack([-0.3 * np.sin(3 * t), -4e-3 * np.sin(4 * t), -0.105 * np.sin(7 * t)], axis=-1)
    dwq = np.stack([-0.43 * 2.45 * np.sin(2.45 * t), -0.81 * np.sin(2.7 * t), zero], axis=-1)
    d = matrix(lam)
    u = apply(d, w1)
    w = wq + u
    dw = dwq + apply(d, dw1) - np.cross(wq, u)
    rho = np.array([0, 0, R])
    f2 = apply(d, f1) + np.cross(dw, rho) + np.cross(w, np.cross(w, rho))
    n, inc, radius = np.sqrt(3.986004418e14 / 26560e3**3), np.deg2rad(55), 26560e3
    arg, node = NODES[:, 1] + n * t[:, None], NODES[:, 0] - OM * t[:, None]
    co, so, cu, su, ci, si = np.cos(node), np.sin(node), np.cos(arg), np.sin(arg), np.cos(inc), np.sin(inc)
    x, y, z = radius * (co * cu - so * su * ci), radius * (so * cu + co * su * ci), radius * su * si
    dx = radius * (-co * su - so * cu * ci) * n + OM * y
    dy = radius * (-so * su + co * cu * ci) * n - OM * x
    position = np.stack([y, z, x], axis=-1)
    speed = np.stack([dy, radius * cu * si * n, dx], axis=-1)
    fixed = np.swapaxes(local_axes(np.full_like(t, lon0), lat), 1, 2)
    place = r[:, None] * fixed[..., 2]
    offset = position - place[:, None]
    distance = np.linalg.norm(offset, axis=-1)
    rate = np.einsum("tni,tni->tn", offset, speed - apply(fixed, v)[:, None]) / distance
    return t, mu, lam, lat, height, v, w, u[:, 2], f1, f2, position, speed, distance, rate


def points(values):
    """Half grid to (step, point, ...)."""
    return np.stack([values[:-2:2], values[1:-1:2], values[2::2]], axis=1)


@cache
def simulated(duration, seed=20240001, start_seed=1, satellites=4, grade="G1", scale=1.0, quiet=False):
    """Inputs, start and truth of a run; `scale` multiplies the initial errors, `quiet` silences the sensors."""
    t, mu, lam, lat, height, v, w, uz, f1, f2, position, speed, distance, rate = motion(duration)
    n = len(t) // 2
    torsion = ANTENNA * normal(seed, 1, 3 * n).reshape(n, 3)
    halves = np.repeat(turn(torsion * STEP / 2), 2, axis=0)
    eta = chained(turn(np.array([0.03, -0.02, 0.04])), halves)
    e = matrix(eta)
    loud = 0.0 if quiet else 1.0
    gyro, accelerometer, doppler, code = 5e-8 * loud, 1e-4 * loud, *(loud * x for x in GRADES[grade])
    noise = {s: normal(seed, s, 3 * n).reshape(n, 1, 3) for s in (2, 3, 4, 5)}
    sky = normal(seed, 6, 8 * n).reshape(n, 1, 4, 2)[:, :, :satellites]
    shown = apply(e, np.stack([w[:, 0], w[:, 1], uz], axis=-1))
    inputs = MastInputs(
        t[::2],
        points(vehicle_rate(t)) + gyro * noise[2],
        points(f1) + accelerometer * noise[3],
        points(shown) + torsion[:, None] + gyro * noise[4],
        points(apply(e, f2)) + accelerometer * noise[5],
        position[:, :satellites],
        speed[:, :satellites],
        points(rate[:, :satellites]) + doppler * sky[..., 0],
        points(distance[:, :satellites]) + code * sky[..., 1],
        MastNoise(5e-8, 1e-4, 5e-8, 1e-4, ANTENNA, *GRADES[grade]),
        MastConstants(R, RE, OM, G),
    )
    truth = {
        "time": t[::2], "mu": mu[::2], "eta": eta[::2], "lambda": lam[::2], "longitude": np.full(n + 1, np.pi / 6),
        "latitude": lat[::2], "height": height[::2], "velocity": v[::2], "mast_rate": w[::2, :2],
    }  # fmt: skip
    d = scale * SDS * normal(start_seed, 7, 17)
    nu = product(product(lam[0], eta[0]), turn(d[9:12]))
    tilted = product(lam[0], turn(d[12:15]))
    start = MastStart(
        product(mu[0], turn(d[:3])), np.pi / 6 + d[3], lat[0] + d[4], v[0] + d[5:8], height[0] + d[8],
        product(conj(tilted), nu), tilted, w[0, :2] + d[15:], SDS * max(scale, 1.0),
    )  # fmt: skip
    return Run(inputs, start, truth)


def small(q):
    """Rotation vector of a quaternion close to +-1."""
    q = q * np.where(q[..., :1] < 0, -1, 1)
    length = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    return 2 * q[..., 1:] * np.where(length > 1e-9, np.arctan2(length, q[..., :1]) / np.maximum(length, 1e-30), 1.0)


def errors(run, result):
    """Errors of a result in the order of the covariance, shape (m, 17): true = estimate [+] error."""
    rows = np.rint((result["time"] - run.truth["time"][0]) / (run.truth["time"][1] - run.truth["time"][0])).astype(int)
    true = {name: values[rows] for name, values in run.truth.items()}
    nu = [product(s["lambda"], s["eta"]) for s in (result, true)]
    plain = ("longitude", "latitude", "velocity", "height")
    numbers = [np.reshape(true[name] - result[name], (len(rows), -1)) for name in plain]
    return np.hstack(
        [
            small(product(conj(result["mu"]), true["mu"])),
            *numbers,
            small(product(conj(nu[0]), nu[1])),
            small(product(conj(result["lambda"]), true["lambda"])),
            true["mast_rate"] - result["mast_rate"],
        ]
    )
