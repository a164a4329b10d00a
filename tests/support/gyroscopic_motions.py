"""Motions over a sphere in float64, every derivative written out by hand: a truth of its own for gyroscopic systems.

Axes X do not rotate, X2 is the Earth's axis; latitude f, absolute longitude L; r^ = (cos f sin L, sin f, cos f cos L).
"""

from dataclasses import dataclass

import numpy as np

R, G, EARTH_RATE = 6371000.0, 9.81, 7.292115e-5
SCHULER_SPEED = float(np.sqrt(G * R))
DEG = np.pi / 180


def waves(t, constant, slope, *terms, square=0.0):
    """constant + slope t + square t^2 + sum A sin(2 pi t/T + p) over terms (A, T, p), and its two derivatives."""
    value = [constant + slope * t + square * t * t, slope + 2 * square * t, 2 * square + 0 * t]
    for amplitude, period, phase in terms:
        w = 2 * np.pi / period
        sine, cosine = amplitude * np.sin(w * t + phase), amplitude * np.cos(w * t + phase)
        value = [value[0] + sine, value[1] + w * cosine, value[2] - w * w * sine]
    return value


def unit_vectors(f, L):
    """East, north and up, shape (n, 3) each."""
    sf, cf, sl, cl = np.sin(f), np.cos(f), np.sin(L), np.cos(L)
    zero = np.zeros_like(sf)
    return np.array([[cl, zero, -sl], [-sf * sl, cf, -sf * cl], [cf * sl, sf, cf * cl]]).swapaxes(1, 2)


def by_angles(latitude, longitude):
    """Vertical and its two derivatives from latitude and absolute longitude, each with theirs."""
    (f, f1, f2), (L, L1, L2) = latitude, longitude
    east, north, up = unit_vectors(f, L)
    cf, sf = np.cos(f), np.sin(f)
    first = f1[:, None] * north + (L1 * cf)[:, None] * east
    along_north = f2 + L1 * L1 * sf * cf
    along_east = L2 * cf - 2 * f1 * L1 * sf
    along_up = -(f1**2) - (L1 * cf) ** 2
    return up, first, along_north[:, None] * north + along_east[:, None] * east + along_up[:, None] * up


def great_circle(angle):
    """From 45 deg of latitude and 30 deg of longitude with azimuth 60 deg; the angle along it with two derivatives."""
    east, north, up = unit_vectors(np.array([45 * DEG]), np.array([30 * DEG]))[:, 0]
    along = np.cos(60 * DEG) * north + np.sin(60 * DEG) * east
    a, a1, a2 = (x[:, None] for x in angle)
    r, turned = np.cos(a) * up + np.sin(a) * along, np.cos(a) * along - np.sin(a) * up
    return r, a1 * turned, a2 * turned - a1**2 * r


def vertical(name, t, eps=1.0):
    zero = 0 * t
    if name == "T0":
        return by_angles([zero + 55 * DEG, zero, zero], waves(t, 30 * DEG, EARTH_RATE))
    if name == "T1":
        return great_circle(waves(t, 0.0, 300 / R))
    if name == "T2":
        return by_angles([zero + 55 * DEG, zero, zero], waves(t, 30 * DEG, EARTH_RATE + 250 / (R * np.cos(55 * DEG))))
    if name == "T3":
        return by_angles(
            waves(t, 50 * DEG, 0, (1.5 * DEG, 3000, 0)),
            waves(t, 30 * DEG, 0.002 * DEG + EARTH_RATE, (DEG, 4500, 0)),
        )
    if name == "T4":
        w = 2 * np.pi / 1800
        return great_circle(waves(t, 100 / w / R, 300 / R, (-100 / w / R, 1800, np.pi / 2)))
    if name == "T5":
        u = t - 1800
        return by_angles(waves(u, DEG, 0.05 / R), waves(u, 30 * DEG, 0.0, square=0.1 / R))
    if name == "TE":
        return by_angles(
            waves(t, 0.0, 0.0, (2 * eps * DEG, 3000, 0)), waves(t, 0.0, eps * 0.004 * DEG, (2 * eps * DEG, 4500, 0))
        )
    assert name == "TP"
    return by_angles([zero + 45 * DEG, zero, zero], waves(t, 0.0, 600 * eps / (R * np.cos(45 * DEG))))


def product(p, q):
    """Hamilton product of quaternions (..., 4)."""
    a, b, c, d = np.moveaxis(p, -1, 0)
    matrix = np.array([[a, -b, -c, -d], [b, a, -d, c], [c, d, a, -b], [d, -c, b, a]])
    return np.einsum("ij...,...j->...i", matrix, q)


def conjugate(q):
    return q * [1, -1, -1, -1]


def turned(q, v):
    """q o v o q~ for unit quaternions (..., 4) and vectors (..., 3)."""
    zero = np.zeros((*np.shape(v)[:-1], 1))
    return product(product(q, np.concatenate([zero, v], axis=-1)), conjugate(q))[..., 1:]


def elementary(axis, angle):
    q = np.zeros((len(angle), 4))
    q[:, 0], q[:, axis] = np.cos(angle / 2), np.sin(angle / 2)
    return q


def angles_of(v, r, v2=None):
    """Latitude, longitude and their rates."""
    f, L = np.arcsin(r[:, 1]), np.arctan2(r[:, 0], r[:, 2])
    east, north, _ = unit_vectors(f, L)
    return f, L, np.sum(v * north, 1), np.sum(v * east, 1) / np.cos(f)


@dataclass
class Motion:
    time: np.ndarray
    rate: np.ndarray
    specific_force: np.ndarray
    attitude: np.ndarray
    vertical: np.ndarray
    velocity: np.ndarray
    latitude: np.ndarray
    longitude_absolute: np.ndarray
    heading: np.ndarray
    pitch: np.ndarray
    roll: np.ndarray
    speed: np.ndarray
    radius: np.ndarray
    radius_rate: np.ndarray
    force_inertial: np.ndarray

    @property
    def vertical_lo(self):
        """This truth is not known any better."""
        return np.zeros_like(self.vertical)

    @property
    def axes(self):
        """Darboux trihedron, rows y1, y2, y3, shape (n, 3, 3)."""
        across = self.velocity - self.vertical * np.sum(self.velocity * self.vertical, 1)[:, None]
        y1 = across / np.linalg.norm(across, axis=1)[:, None]
        return np.stack([y1, np.cross(self.vertical, y1), self.vertical], axis=1)


def motion(name, t, eps=1.0, climb=0.0):
    """Motion at times t; with `climb` at radius R + climb (1 - cos(2 pi t/3600)) under attraction g R^2/r^2."""
    r, r1, r2 = vertical(name, t, eps)
    f, L, f1, L1 = angles_of(r1, r)
    radius, radius1, radius2 = waves(t, R + climb, 0.0, (-climb, 3600, np.pi / 2))
    velocity = radius[:, None] * r1 + radius1[:, None] * r
    force = radius[:, None] * r2 + 2 * radius1[:, None] * r1 + (radius2 + G * R**2 / radius**2)[:, None] * r
    P, P1, _ = waves(t, 40 * DEG, DEG / 60, (20 * DEG, 1200, 0))
    Q, Q1, _ = waves(t, 2 * DEG, 0, (4 * DEG, 500, 0))
    roll, roll1, _ = waves(t, -DEG, 0, (8 * DEG, 700, 1))
    s, rate = np.tile([1.0, 0, 0, 0], (len(t), 1)), np.zeros((len(t), 3))
    for axis, angle, angle1 in ((2, L, L1), (1, -f, -f1), (3, -P, -P1), (1, Q, Q1), (2, roll, roll1)):
        q = elementary(axis, angle)
        s, rate = product(s, q), turned(conjugate(q), rate)
        rate[:, axis - 1] += angle1
    return Motion(
        time=t, rate=rate, specific_force=turned(conjugate(s), force), attitude=s, vertical=r, velocity=velocity,
        latitude=f, longitude_absolute=L, heading=P % (2 * np.pi), pitch=Q, roll=roll,
        speed=np.linalg.norm(radius[:, None] * r1, axis=1), radius=radius, radius_rate=radius1, force_inertial=force,
    )  # fmt: skip


def grid(duration, step):
    """Starts, middles and ends of steps."""
    return np.linspace(0.0, duration, 2 * round(duration / step) + 1)
