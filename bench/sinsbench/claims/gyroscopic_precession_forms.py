"""Forms of the equations of sections 1 and 2 of Chelnokov 1991: precession of pendulums, frames and compasses.

A function takes data and returns the forms of one equation: the text of the part in question, with what the
definitions give and what the form gives.
"""

from collections.abc import Mapping, Sequence

from sinsbench.claims.gyroscopic_form_data import (
    AS_PRINTED,
    Data,
    Sides,
    moment_of_forces,
    momentum_axis_rate,
    rate_of,
    scalar,
    times,
    total,
    vector,
)
from sinsbench.claims.gyroscopic_states import Instant
from sinsref.arithmetic import Number
from sinsref.quaternion import conjugate, cross, dot, normalised, product, rotate

# Section 1


def rate_of_the_reference(data: Data) -> Mapping[str, Sides]:
    """(1.1): which rate turns X to Z, as 2 nu' = nu o rate_Z tells; that of eta is what e turns at."""
    (nu, nu_), (lambda_, lambda__) = data.frame(), data.frame()
    e, e_ = product(nu, lambda_), total(product(nu_, lambda_), product(nu, lambda__))
    of_eta = rotate(lambda_, rate_of(e, e_))
    return {
        "omega0, omega*": (times(2, nu_), product(nu, vector(rate_of(nu, nu_)))),
        "omega*, omega*": (times(2, nu_), product(nu, vector(of_eta))),
    }


def change_of_momentum(data: Data) -> Mapping[str, Sides]:
    """(1.3): a momentum vector that changes at a rate M' + M''."""
    rate, value = data.vector(), data.vector()
    series = [data.ar.variable(x, slope) for x, slope in zip(value, rate, strict=True)]
    size = data.ar.sqrt(dot(series, series))
    given = scalar(dot(times(1 / size[0], value), rate))
    return {"L'": (given, scalar(size[1])), "L": (given, scalar(size[0]))}


def turning_axes(data: Data) -> Mapping[str, Sides]:
    """(1.4): kinematics of e."""
    e, e_ = data.frame()
    given = product(e, vector(rate_of(e, e_)))
    return {"2 e'": (given, times(2, e_)), "2 e": (given, times(2, e))}


def general_rate(data: Data) -> Mapping[str, Sides]:
    """(1.7), with a_k along the momentum or along l."""
    axis, arm = data.direction(), data.arm
    known = vector(momentum_axis_rate(data, axis, arm))

    def form(projection: Number) -> Sides:
        ratio = data.mass / data.momentum
        return known, vector(
            total(
                times(ratio * dot(axis, arm), data.force),
                times(-ratio * projection, arm),
                times(data.spin, axis),
                times(1 / data.momentum, cross(axis, data.moment)),
            )
        )

    length = normalised(data.balls, arm)
    return {"L": form(dot(data.force, axis)), "l": form(dot(data.force, length))}


def general_rate_as_printed(data: Data) -> Mapping[str, Sides]:
    """(1.7) as it stands."""
    (sides, *_) = general_rate(data).values()
    return {AS_PRINTED: sides}


def rate_in_own_axes(data: Data) -> Mapping[str, Sides]:
    """(1.8) with k = 3: everything resolved in eta."""
    axis, force, arm = [data.zero, data.zero, data.one], data.force, data.arm
    inner = total(vector(data.moment), times(data.mass, product(vector(force), vector(arm))))
    along = data.spin - data.mass / data.momentum * dot(force, arm)
    given = total(times(along, axis), times(-1 / data.momentum, product(inner, vector(axis))[1:]))
    return {AS_PRINTED: (vector(momentum_axis_rate(data, axis, arm)), vector(given))}


def pendulum(data: Data) -> Mapping[str, Sides]:
    """Before (1.9): on which side of the pivot the centre of mass lies."""
    axis, ratio = data.direction(), data.mass * data.length / data.momentum
    given = total(
        times(-ratio, data.force),
        times(ratio * dot(data.force, axis) + data.spin, axis),
        times(1 / data.momentum, cross(axis, data.moment)),
    )
    return {
        text: (vector(momentum_axis_rate(data, axis, times(data.length * sign, axis))), vector(given))
        for text, sign in (("-l eta_k", -1), ("l eta_k", 1))
    }


def momentum(data: Data) -> Mapping[str, Sides]:
    """(1.12): the moment M enters by its projection."""
    axis = data.direction()
    known = scalar(dot(axis, moment_of_forces(data, data.arm)))
    inertial = scalar(data.mass * dot(axis, cross(data.force, data.arm)))
    return {
        "eta_k . M": (known, total(inertial, scalar(dot(axis, data.moment)))),
        "eta_k x M": (known, total(inertial, vector(cross(axis, data.moment)))),
    }


def attitude(data: Data) -> Mapping[str, Sides]:
    """(1.14): kinematics of s."""
    s, s_ = data.frame()
    given = product(s, vector(rate_of(s, s_)))
    return {"2 s'": (given, times(2, s_)), "2 s o s'": (given, times(2, product(s, s_)))}


# Section 2


def pendulum_deviation(data: Data) -> Mapping[str, Sides]:
    """(2.7), from e = nu o lambda, (2.3) and (2.4)."""
    (nu, nu_), e = data.frame(), data.frame()[0]
    up, moment, size = [data.zero, data.zero, data.one], data.moment, data.momentum
    ml = data.mass * data.length
    turning = total(times(-ml / size, data.force), times(-1 / size, rotate(e, cross(moment, up))))
    e_ = times(data.one / 2, product(vector(turning), e))
    back = conjugate(nu)
    lambda_, lambda__ = product(back, e), total(product(conjugate(nu_), e), product(back, e_))
    known = times(-1, product(product(lambda_, vector(moment)), vector(up)))
    of_z, of_eta = rate_of(nu, nu_), rotate(back, turning)
    changes = {"H'": moment[2], "H": size}

    def form(rate: Sequence[Number], change: Number) -> Sides:
        factor = total(times(size, vector(rate)), times(ml, vector(rotate(back, data.force))), scalar(change))
        return known, total(times(2 * size, lambda__), product(factor, lambda_))

    return {
        f"(H {name}_Z + m l a_Z + {change})": form(rate, changes[change])
        for name, rate in (("omega0", of_z), ("omega*", of_eta))
        for change in changes
    }


def compass_change(data: Data) -> Mapping[str, Sides]:
    """(2.12): the momentum H along Y2, the centre of mass at -l Y3; H' is what (1.3) gives."""
    right = scalar(data.mass * data.length * data.force[0] + data.moment[1])
    change = moment_of_forces(data, [data.zero, data.zero, -data.length])[1]
    return {"H'": (scalar(change), right), "H": (scalar(data.momentum), right)}


def compass_rate(data: Data) -> Mapping[str, Sides]:
    """(2.13), third component, from the theorem of momentum (1.2) with the axis i2."""
    axis, arm = [data.zero, data.one, data.zero], [data.zero, data.zero, -data.length]
    ml, (m1, m2, m3) = data.mass * data.length, data.moment
    known = vector(momentum_axis_rate(data, axis, arm))

    def form(third: Number) -> Sides:
        return known, vector([m3 / data.momentum, data.spin, third / data.momentum])

    return {
        "m l a_Y2 - M_Y1": form(ml * data.force[1] - m1),
        "m l a_Y1 - M_Y2": form(ml * data.force[0] - m2),
    }


def rotors(data: Data) -> Mapping[str, Sides]:
    """(2.14): the moments about the housing axes Y3 of rotors with momenta B(sin E, cos E, 0), B(-sin E, cos E, 0)."""
    size, rate, (sine, cosine) = data.number(), data.vector(), data.balls.sin_cos(data.angle())
    first, second = (cross(rate, [size * x, size * cosine, size * 0])[2] for x in (sine, -sine))
    given = scalar(-(first - second) / (2 * size * sine))
    return {"omega_Y2": (scalar(rate[1]), given), "omega_Y1": (scalar(rate[0]), given)}


def compass_speed(data: Data) -> Mapping[str, Sides]:
    """(2.15): speed of the manoeuvre and specific force along it."""
    at = Instant(data.balls, "T3", 1799)
    along = scalar(dot(at.force, at.axes[0])[0])
    return {"h'": (along, scalar(at.speed[1])), "h": (along, scalar(at.speed[0]))}


def resolved_force(data: Data) -> Mapping[str, Sides]:
    """After (2.15): the specific force in the axes eta, by (1.15), (1.16)."""
    e, s = data.frame()[0], data.frame()[0]
    mu, force = product(conjugate(e), s), vector(data.force)
    known = product(product(mu, force), conjugate(mu))
    seen = product(product(s, force), conjugate(s))
    return {
        "conj e o s o a_xi o conj s o e": (known, product(product(conjugate(e), seen), e)),
        "e o s o a o e": (known, product(product(e, product(s, force)), e)),
    }
