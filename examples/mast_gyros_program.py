"""The estimator of mast_gyros.py as a program of plain Python: CSV, a row a step comes in, a row a second goes out.

Score it: sinsbench score --command "python3 examples/mast_gyros_program.py" --on mast_antenna
"""

import csv
import math
import sys

AXES, PARTS = "xyz", "wxyz"


def product(a, b):
    """Hamilton product of two quaternions, scalar first."""
    (a0, a1, a2, a3), (b0, b1, b2, b3) = a, b
    return (
        a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
        a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
        a0 * b2 - a1 * b3 + a2 * b0 + a3 * b1,
        a0 * b3 + a1 * b2 - a2 * b1 + a3 * b0,
    )


def conjugate(q):
    """Return the inverse of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def turned(q, rate, step):
    """Return an attitude after a step with a constant rate in its own axes."""
    size = math.hypot(*rate) * step / 2
    factor = math.sin(size) / size * step / 2 if size else 0.0
    return product(q, (math.cos(size), *(factor * x for x in rate)))


lines = csv.reader(sys.stdin)
places = {name: place for place, name in enumerate(next(lines))}


def vector(row, stem, axes=AXES):
    """Return the numbers of a row in the columns of a vector."""
    return tuple(float(row[places[f"{stem}_{axis}"]]) for axis in axes)


row = next(lines)
first = {name: float(row[place]) for name, place in places.items()}
step, every = first["interval"], round(1 / first["interval"])
mu, eta0, lambda0 = (vector(row, f"{name}0", PARTS) for name in ("mu", "eta", "lambda"))
chi = product(mu, product(lambda0, eta0))
radius = first["radius"] + first["height0"]
# The mast itself is left where it was: nu = conj(mu) o chi is divided into lambda, as at the start, and eta.
kept = [repr(x) for x in (*lambda0, *(first[f"v_{name}0"] for name in ("east", "north", "up")))]
kept += [repr(first[f"mast_absolute_rate0_{axis}"]) for axis in "xy"]

names = [f"{name}_{axis}" for name in ("mu", "eta") for axis in PARTS]
names += ["longitude", "latitude", "height", *(f"lambda_{axis}" for axis in PARTS), "v_east", "v_north", "v_up"]
print("time", *names, "mast_absolute_rate_x", "mast_absolute_rate_y", sep=",")


def tell(time):
    """Write the row of a time."""
    gone = time - (first["time"] - step)
    eta = product(conjugate(lambda0), product(conjugate(mu), chi))
    longitude = first["longitude0"] + gone * first["v_east0"] / (radius * math.cos(first["latitude0"]))
    latitude = first["latitude0"] + gone * first["v_north0"] / radius
    height = first["height0"] + gone * first["v_up0"]
    print(*map(repr, (time, *mu, *eta, longitude, latitude, height)), *kept, sep=",")


tell(first["time"] - step)
while row:
    mu = turned(mu, vector(row, "middle_angular_rate1"), step)
    chi = turned(chi, vector(row, "middle_angular_rate2"), step)
    if int(row[places["sample"]]) % every == 0:
        tell(float(row[places["time"]]))
    row = next(lines, None)
