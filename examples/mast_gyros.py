"""An estimator of one's own for `mast_antenna`: both attitudes by the gyros alone, the place by the start's velocity.

Score it beside a filter:

    sinsbench score mekf_nu_az examples/mast_gyros.py:gyros_alone --on mast_antenna --cases examples/mast_seeds.toml
"""

import numpy as np


def product(a, b):
    """Hamilton product of two quaternions, scalar first."""
    scalar = a[0] * b[0] - a[1:] @ b[1:]
    return np.array([scalar, *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


def turned(attitudes, rate, step):
    """Return an attitude after each step, first the one before; the rate is that at the middle of the step."""
    for x in rate * step / 2:
        size = np.linalg.norm(x)
        attitudes.append(product(attitudes[-1], np.array([np.cos(size), *(np.sinc(size / np.pi) * x)])))
    return np.array(attitudes)


def gyros_alone(inputs, start):
    """Estimate a row a second; `sinsbench.subjects.mast.contract` says what is given and what is returned."""
    every = round(1 / inputs.step)
    inverse = start.lambda_ * [1, -1, -1, -1]
    mu = turned([start.mu], inputs.rate1[:, 1], inputs.step)[::every]
    chi = product(start.mu, product(start.lambda_, start.eta))
    chi = turned([chi], inputs.rate2[:, 1], inputs.step)[::every]
    # The mast itself is left where it was: nu = conj(mu) o chi is divided into lambda, as at the start, and eta.
    eta = [product(inverse, product(m * [1, -1, -1, -1], c)) for m, c in zip(mu, chi, strict=True)]
    time = inputs.time[::every]
    rows = np.ones((len(time), 1))
    gone, radius = time - time[0], inputs.constants.earth_radius + start.height
    return {
        "time": time,
        "mu": mu,
        "longitude": start.longitude + gone * start.velocity[0] / (radius * np.cos(start.latitude)),
        "latitude": start.latitude + gone * start.velocity[1] / radius,
        "velocity": rows * start.velocity,
        "height": start.height + gone * start.velocity[2],
        "eta": eta,
        "lambda": rows * start.lambda_,
        "mast_rate": rows * start.mast_rate,
    }
