r"""Error equations of a strapdown INS along the equator: exact solution at every speed.

The state is (dv_N, dv_H, dv_E, dH, dphi, dlambda): errors, computed minus true, of the velocity north, up
and east (m/s), of height (m), latitude and longitude (rad), for flight along the equator of a spherical
Earth at constant speed and height.

North and latitude oscillate by themselves. The other four obey :math:`x' = A_4 x` with a characteristic
polynomial :math:`\beta^4 + p\beta^2 - q` that is even, so that

.. math:: e^{A_4 t} = c_0 + c_1 A_4 + c_2 A_4^2 + c_3 A_4^3

with four functions of time that depend on p and q alone. They are symmetric in the roots rho_1, rho_2 of
:math:`\rho^2 + p\rho - q`: no division by the frame rate, by the specific force or by a root, hence no
degenerate speed. `coupled_functions` evaluates them from the roots where these are apart, and from an
everywhere convergent series in p and q where they are not.

Source: Loginov, Tkachenko, Chelnokov 2013, sections 3 and 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, e, log2

from sinsref.arithmetic import Arithmetic, Number
from sinsref.earth import EQUATORIAL_GRAVITY, ROTATION_RATE, SEMI_MAJOR_AXIS
from sinsref.exact import ExactNumber

#: Places of (dv_H, dv_E, dH, dlambda) in the state.
COUPLED = (1, 2, 3, 5)


@dataclass(frozen=True)
class EquatorModel:
    """Constants of the error equations (10) in an arithmetic.

    Attributes
    ----------
    v_east : Number
        Speed over the Earth, m/s.
    radius : Number
        R = a + H, m.
    gravity : Number
        g at that height, m/s^2; inverse-square (the printed first power of R is a misprint).
    frame_rate : Number
        omega_N = u + v/R, rad/s.
    coriolis_rate : Number
        2 u + v/R, rad/s.
    specific_force : Number
        a_H = g - 2 u v - v^2/R, m/s^2.
    a24 : Number
        2 g/R - (v/R)^2, 1/s^2.
    schuler_rate : Number
        omega = sqrt(g/R), rad/s.
    p, q : Number
        Coefficients of the biquadratic beta^4 + p beta^2 - q.
    """

    v_east: Number
    radius: Number
    gravity: Number
    frame_rate: Number
    coriolis_rate: Number
    specific_force: Number
    a24: Number
    schuler_rate: Number
    p: Number
    q: Number

    @classmethod
    def at(cls, ar: Arithmetic, v_east: ExactNumber, height: ExactNumber) -> EquatorModel:
        """Return the model for a speed east (m/s) and a height (m)."""
        u, a, v = ar.number(ROTATION_RATE), ar.number(SEMI_MAJOR_AXIS), ar.number(v_east)
        radius = a + ar.number(height)
        gravity = ar.number(EQUATORIAL_GRAVITY) * (a / radius) * (a / radius)
        turn = v / radius
        frame_rate, coriolis_rate = u + turn, u * 2 + turn
        specific_force = gravity - v * coriolis_rate
        a24 = gravity * 2 / radius - turn * turn
        p = frame_rate * coriolis_rate * 2 - a24 + specific_force / radius
        q = (a24 + frame_rate * turn * 2) * specific_force / radius
        return cls(
            v,
            radius,
            gravity,
            frame_rate,
            coriolis_rate,
            specific_force,
            a24,
            ar.sqrt(gravity / radius),
            p,
            q,
        )

    def coupled_matrix(self, ar: Arithmetic) -> list[list[Number]]:
        """Return the matrix of (dv_H, dv_E, dH, dlambda): rows and columns 2, 3, 4, 6 of (10)."""
        zero, one, R = ar.number(0), ar.number(1), self.radius
        return [
            [zero, self.frame_rate * 2, self.a24, zero],
            [-self.coriolis_rate, zero, zero, -self.specific_force],
            [one, zero, zero, zero],
            [zero, one / R, -(self.v_east / R / R), zero],
        ]

    def matrix(self, ar: Arithmetic) -> list[list[Number]]:
        """Return the 6 x 6 matrix A of (10)."""
        full = [[ar.number(0)] * 6 for _ in range(6)]
        full[0][4], full[4][0] = -self.gravity, ar.number(1) / self.radius
        for i, row in zip(COUPLED, self.coupled_matrix(ar), strict=True):
            for j, element in zip(COUPLED, row, strict=True):
                full[i][j] = element
        return full


def coupled_functions(ar: Arithmetic, p: Number, q: Number, time: Number) -> list[Number]:
    r"""Return c_0 ... c_3 of ``exp(A t) = c_0 + c_1 A + c_2 A^2 + c_3 A^3`` for a matrix with A^4 + p A^2 - q = 0.

    With :math:`f_e(x) = \cosh(\sqrt x t)` and :math:`f_o(x) = \sinh(\sqrt x t)/\sqrt x`, and for each of
    them its mean m and its divided difference d over the two roots, the even part of the exponential is m +
    d (A^2 + p/2); the odd part is A times the same of f_o.

    Parameters
    ----------
    ar : Arithmetic
    p, q : Number
        Coefficients of the biquadratic.
    time : Number
        s.
    """
    discriminant = p * p + q * 4
    scale = ar.magnitude(p) ** 2 + 4 * ar.magnitude(q)
    # The functions of the roots lose about as many bits as the roots are close to each other or to zero: 20
    # are allowed.
    apart = ar.number(scale * 2.0**-20)
    if ar.sign(abs(discriminant) - apart) > 0:
        half = ar.sqrt(abs(discriminant)) / 2
        if ar.sign(discriminant) < 0:
            return _of_complex_roots(ar, p, half, time)
        if ar.sign(abs(q) - apart) > 0:
            return _of_real_roots(ar, p, half, time)
    return series_functions(ar, p, q, time)


def _of_real_roots(ar: Arithmetic, p: Number, half: Number, time: Number) -> list[Number]:
    """Return c_0 ... c_3 for the roots -p/2 +- half."""
    values = []
    for rho in (half - p / 2, -half - p / 2):
        root = ar.sqrt(abs(rho))
        sine, cosine = ar.sinh_cosh(root * time) if ar.sign(rho) > 0 else ar.sin_cos(root * time)
        values.append((cosine, sine / root))
    (even_1, odd_1), (even_2, odd_2) = values
    slope_even, slope_odd = (even_1 - even_2) / (half * 2), (odd_1 - odd_2) / (half * 2)
    return [
        (even_1 + even_2 + slope_even * p) / 2,
        (odd_1 + odd_2 + slope_odd * p) / 2,
        slope_even,
        slope_odd,
    ]


def _of_complex_roots(ar: Arithmetic, p: Number, half: Number, time: Number) -> list[Number]:
    """Return c_0 ... c_3 for the roots -p/2 +- i half: real parts, and imaginary parts over half.

    The square root of -p/2 + i half is a + i b; cosh((a + i b) t) and sinh((a + i b) t)/(a + i b) follow by
    addition.
    """
    modulus = ar.sqrt(p * p / 4 + half * half)
    # The larger of a and b comes from the sum that does not cancel, the other from 2 a b = half.
    larger = ar.sqrt((modulus + abs(p) / 2) / 2)
    smaller = half / (larger * 2)
    a, b = (smaller, larger) if ar.sign(p) > 0 else (larger, smaller)
    (sinh, cosh), (sin, cos) = ar.sinh_cosh(a * time), ar.sin_cos(b * time)
    slope_even = sinh * sin / half
    mean_odd = (sinh * cos * a + cosh * sin * b) / modulus
    slope_odd = (cosh * sin * a - sinh * cos * b) / modulus / half
    return [cosh * cos + slope_even * p / 2, mean_odd + slope_odd * p / 2, slope_even, slope_odd]


def series_functions(ar: Arithmetic, p: Number, q: Number, time: Number, forcing: Number | None = None) -> list[Number]:
    """Return c_0 ... c_3 by their power series in time: for every p and q, no root is taken.

    Parameters
    ----------
    ar : Arithmetic
    p, q : Number
        Coefficients of the biquadratic.
    time : Number
        s.
    forcing : Number, optional
        With a number r: the functions of ``(f(A^2) - f(r)) / (A^2 - r)`` in place of f(A^2), which answer a
        force that oscillates with the square of its rate equal to -r. Nothing is divided by A^2 - r:
        resonance is an ordinary value.

    Raises
    ------
    OverflowError
        If the functions grow beyond the range of binary64, about exp(690).

    Notes
    -----
    With B = A^2 every power is B^n = alpha_n + beta_n B, and multiplying by B gives alpha' = q beta,
    beta' = alpha - p beta. The terms reach exp(sqrt|rho| t) before they fall; `guard_bits` says what the working
    precision must allow for.
    """
    bound = ar.magnitude(p) + ar.magnitude(q) ** 0.5  # at least |rho|: |rho|^2 <= |p| |rho| + |q|
    if forcing is not None:
        bound = max(bound, ar.magnitude(forcing))
    square = time * time
    reach = bound * ar.magnitude(square)
    one = ar.number(1)
    alpha, beta = (one, ar.number(0)) if forcing is None else (ar.number(0), ar.number(0))
    power = one  # forcing**n
    even, odd = one, time  # t^(2n)/(2n)!, t^(2n+1)/(2n+1)!
    sums = [alpha * even, alpha * odd, beta * even, beta * odd]
    size, n = 1.0, 0
    # The first terms of the sums are up to reach^2 below the size: they set the scale where the reach is small.
    enough = ar.resolution * 1e-6 * min(1.0, reach) ** 2
    while n < 3 or size > enough or 4 * reach > (2 * n) ** 2:
        n += 1
        alpha, beta = q * beta, alpha - p * beta
        if forcing is not None:
            alpha, power = alpha + power, power * forcing
        even = even * square / ((2 * n - 1) * (2 * n))
        odd = odd * square / ((2 * n) * (2 * n + 1))
        for place, term in enumerate((alpha * even, alpha * odd, beta * even, beta * odd)):
            sums[place] = sums[place] + term
        size *= reach / ((2 * n - 1) * (2 * n))
        if size > 1e300:
            raise OverflowError(f"the terms of the series grow beyond binary64: sqrt({reach:.3g}) e-foldings")
    # |alpha_n| <= n^2 bound^(n-s), |beta_n| <= n^2 bound^(n-s-1), s = 1 with forcing, else 0. Behind the
    # last term they fall by a quarter each and n^2 grows by less than a half, so all that is left is within
    # the size of n^2 bound^n times the last factor.
    base = ar.number(max(bound, 1e-300))
    last = ar.number(n * n)
    for _ in range(n if forcing is None else n - 1):
        last = last * base
    tails = (last * even, last * odd, last * even / base, last * odd / base)
    return [ar.widen(total, tail) for total, tail in zip(sums, tails, strict=True)]


def guard_bits(ar: Arithmetic, model: EquatorModel, time: Number) -> int:
    """Return how many bits `series_functions` may lose by cancellation up to a time."""
    bound = ar.magnitude(model.p) + ar.magnitude(model.q) ** 0.5
    reach = float(bound**0.5 * ar.magnitude(time))
    return ceil(2 * reach * log2(e)) + 8


def apply(matrix: Sequence[Sequence[Number]], vector: Sequence[Number]) -> list[Number]:
    """Return the product of a matrix and a vector."""
    rows = []
    for row in matrix:
        total = row[0] * vector[0]
        for element, x in zip(row[1:], vector[1:], strict=True):
            total = total + element * x
        rows.append(total)
    return rows


def polynomial(ar: Arithmetic, model: EquatorModel, c: Sequence[Number], vector: Sequence[Number]) -> list[Number]:
    """Return (c_0 + c_1 A4 + c_2 A4^2 + c_3 A4^3) v for a vector v of the coupled channel."""
    matrix = model.coupled_matrix(ar)
    total = [c[3] * x for x in vector]
    for coefficient in (c[2], c[1], c[0]):
        total = [x + coefficient * y for x, y in zip(apply(matrix, total), vector, strict=True)]
    return total


def transition(ar: Arithmetic, model: EquatorModel, time: Number) -> list[list[Number]]:
    """Return the transition matrix P(t) of (20), 6 x 6."""
    full = [[ar.number(0)] * 6 for _ in range(6)]
    sine, cosine = ar.sin_cos(model.schuler_rate * time)
    speed = model.schuler_rate * model.radius  # sqrt(g R)
    full[0][0], full[0][4], full[4][0], full[4][4] = cosine, -(speed * sine), sine / speed, cosine
    c = coupled_functions(ar, model.p, model.q, time)
    for n, j in enumerate(COUPLED):
        column = polynomial(ar, model, c, [ar.number(int(n == m)) for m in range(4)])
        for i, element in zip(COUPLED, column, strict=True):
            full[i][j] = element
    return full


def homogeneous(ar: Arithmetic, model: EquatorModel, initial: Sequence[Number], time: Number) -> list[Number]:
    """Return X(t) = P(t) X(0), the solution (20) without orientation errors.

    Parameters
    ----------
    ar : Arithmetic
    model : EquatorModel
    initial : sequence of 6 Number
        X(0).
    time : Number
        s.
    """
    sine, cosine = ar.sin_cos(model.schuler_rate * time)
    speed = model.schuler_rate * model.radius
    c = coupled_functions(ar, model.p, model.q, time)
    coupled = polynomial(ar, model, c, [initial[i] for i in COUPLED])
    north = initial[0] * cosine - initial[4] * (speed * sine)
    latitude = initial[4] * cosine + initial[0] * (sine / speed)
    return [north, *coupled[:3], latitude, coupled[3]]
