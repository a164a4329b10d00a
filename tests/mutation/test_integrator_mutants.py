"""Every planted defect in the integrators must be found.

The kernels are run un-jitted in exact arithmetic, on power series in the sampling interval with rational
coefficients, beside the power series of the solution of the differential equations. A method of order rho agrees
with it in every coefficient up to h^rho: there is no tolerance for a defect to hide in.
"""

from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from gmpy2 import mpq  # four times as fast as Fraction

from mutants import Planter, is_seen
from sinsbench.instrumentation import rebuilt_kernels
from sinsbench.subjects.rotation_vector_methods import (
    COSINE_SERIES,
    DUAL_SERIES,
    METHODS,
    PANOV_6,
    SINE_SERIES,
    Coefficients,
    binary64_coefficients,
)

DEGREE = 7  # one more than the highest order
FACTORS = {"times 1.001": mpq(1001, 1000), "sign": mpq(-1), "dropped": mpq(0)}


class Series:
    """A power series in the interval h with rational coefficients, up to h^DEGREE."""

    def __init__(self, coefficients):
        self.terms = list(coefficients) + [mpq(0)] * (DEGREE + 1 - len(coefficients))

    @staticmethod
    def of(value):
        return value if isinstance(value, Series) else Series([mpq(value)])

    def __add__(self, other):
        return Series([a + b for a, b in zip(self.terms, Series.of(other).terms, strict=True)])

    def __neg__(self):
        return Series([-a for a in self.terms])

    def __sub__(self, other):
        return self + -Series.of(other)

    def __rsub__(self, other):
        return Series.of(other) - self

    def __mul__(self, other):
        if not isinstance(other, Series):
            return Series([a * mpq(other) for a in self.terms])
        product = [mpq(0)] * (DEGREE + 1)
        for i, a in enumerate(self.terms):
            if a:
                for j in range(DEGREE + 1 - i):
                    product[i + j] += a * other.terms[j]
        return Series(product)

    __radd__, __rmul__ = __add__, __mul__

    def __le__(self, limit):
        return self.terms[0] <= limit  # small rotations: the power series of the kernels, never the closed forms

    def agrees(self, other, order):
        return self.terms[: order + 1] == other.terms[: order + 1]


def multiply(a, b):
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    ]


def turn(q, v):
    return multiply(multiply(q, [0, *v]), conjugated(q))[1:]


def conjugated(q):
    return [q[0], *(-x for x in q[1:])]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def total(vectors):
    return [sum(components[1:], start=components[0]) for components in zip(*vectors, strict=True)]


RANDOM = np.random.default_rng(2013)
RATE, FORCE = (
    [[mpq(int(x), 3) for x in RANDOM.integers(-4, 5, size=3)] for _ in range(DEGREE)] for _ in range(2)
)  # coefficients of the polynomials omega(t) and a(t), one row a power
ATTITUDE = [mpq(x, 2) for x in (1, 1, -1, 1)]
VELOCITY = [mpq(x) for x in (3, -2, 5)]


def increments(polynomial, samples):
    """Integrals over [(j - 1) h, j h], j = 1 ... samples, as series in h: an object array (samples, 3)."""
    table = np.empty((samples, 3), dtype=object)
    for j in range(samples):
        for axis in range(3):
            terms = [row[axis] * ((j + 1) ** (k + 1) - j ** (k + 1)) / (k + 1) for k, row in enumerate(polynomial)]
            table[j, axis] = Series([mpq(0), *terms])
    return table


@cache
def solution(multiple):
    """Attitude and both velocities at t = multiple h: 2 Lambda' = Lambda o omega, W_I' = Lambda o a o conj(Lambda)."""
    zero = mpq(0)
    attitude = [[x] for x in ATTITUDE]
    for k in range(DEGREE):
        rate = [
            sum(terms)
            for terms in zip(
                *(multiply([x[i] for x in attitude], [zero, *RATE[k - i]]) for i in range(k + 1)), strict=True
            )
        ]
        for x, derivative in zip(attitude, rate, strict=True):
            x.append(derivative / 2 / (k + 1))
    q = [Series(x) for x in attitude]
    force = turn(q, [Series([row[axis] for row in FORCE]) for axis in range(3)])
    inertial = [
        Series([w, *(f.terms[k] / (k + 1) for k in range(DEGREE))]) for w, f in zip(VELOCITY, force, strict=True)
    ]
    at = [[Series([c * multiple**k for k, c in enumerate(x.terms)]) for x in group] for group in (q, inertial)]
    return at[0], at[1], turn([at[0][0], *(-x for x in at[0][1:])], at[1])


def exact_coefficients(method):
    floats = binary64_coefficients(method)
    tables = {"pair": method.pairs, "triple": method.triples, "quartic": method.quartics}
    exact = {
        name: (*table.values(), *[mpq(0)] * (len(getattr(floats, name)) - len(table))) for name, table in tables.items()
    }
    return floats._replace(**exact, cosine=COSINE_SERIES, sine=SINE_SERIES, dual=DUAL_SERIES)


INCREMENTS = tuple(map(tuple, increments(RATE, 8))), tuple(map(tuple, increments(FORCE, 8)))
START = tuple(map(Series.of, ATTITUDE)), tuple(map(Series.of, VELOCITY))
START_BODY = tuple(turn([ATTITUDE[0], *(-x for x in ATTITUDE[1:])], VELOCITY))
NOTHING = (Series([mpq(0)]),) * 4


def agree(computed, exact, order):
    """Agree up to h^order; zip refuses a missing component."""
    return all(
        Series.of(x).agrees(y, order)
        for group, other in zip(computed, exact, strict=True)
        for x, y in zip(group, other, strict=True)
    )


def coefficients_hold(method, kernels):
    """One step of `step` has the order claimed, and not a higher one in attitude and velocities together."""
    p, b = INCREMENTS
    state = kernels["step"]((*START, tuple(map(Series.of, START_BODY))), p[:4], b[:4], exact_coefficients(method))
    return agree(state, solution(4), method.order) and not agree(state, solution(4), method.order + 1)


def batch_is_exact(kernels):
    """Two steps of each loop, from object arrays, agree with the solution of the differential equations."""
    angle, velocity = (np.array(rows, dtype=object) for rows in INCREMENTS)
    coefficients, like = exact_coefficients(PANOV_6), (None,) * 4
    body = tuple(map(Series.of, START_BODY))
    starts = {"integrate": (*START, body), "integrate_compensated": (START[0], NOTHING, START[1], NOTHING[:3])}
    for name, state in starts.items():
        outputs = [np.empty((2, columns), dtype=object) for columns in (4, 3, 3)]
        kernels[name](state, angle, velocity, like, coefficients, *outputs)
        if not all(agree([o[k] for o in outputs], solution(4 * k + 4), 6) for k in range(2)):
            return False
    attitude = np.empty((2, 4), dtype=object)
    kernels["integrate_attitude"](START[0], angle, like, coefficients, attitude)
    return all(agree([attitude[k]], solution(4 * k + 4)[:1], 6) for k in range(2))


def carries_are_taken_back(kernels):
    """In exact arithmetic a carry shifts its own component by as much, and leaves no carry."""
    coefficients = exact_coefficients(PANOV_6)
    q_carry, w_carry = (tuple(Series([mpq(k, 7)]) for k in range(1, n)) for n in (5, 4))
    p, b = (rows[:4] for rows in INCREMENTS)
    with_carry = kernels["compensated_step"]((START[0], q_carry, START[1], w_carry), p, b, coefficients)
    without = kernels["compensated_step"]((START[0], NOTHING, START[1], NOTHING[:3]), p, b, coefficients)
    shifted = [[x - c for x, c in zip(without[k], carry, strict=True)] for k, carry in ((0, q_carry), (2, w_carry))]
    return agree(with_carry, [shifted[0], NOTHING, shifted[1], NOTHING[:3]], DEGREE)


def summation_is_compensated(kernels):
    """Total, carry and term of sizes 1, 1e-17, 1e-3: what a rounded addition loses is exactly the new carry."""
    total, carry, term = 1.0, 3e-17, 1.1e-3
    updated, lost = kernels["add_compensated"](total, carry, term)
    return lost != 0 and mpq(updated) - mpq(lost) == mpq(total) + mpq(term - carry)


def closed_forms_continue_the_series(kernels):
    """Where both hold, at a rotation by 1 rad; the series are checked exactly elsewhere."""
    phi, phi_dual = (0.6, 0.0, 0.8), (0.3, -0.2, 0.5)
    results = []
    for limit in (2.0, 0.0):
        c = binary64_coefficients(PANOV_6, series_limit=limit)
        rotation, moment = kernels["rotation_biquaternion"](phi, phi_dual, c)
        results.append([*rotation, *moment, kernels["half_angle_cosine_less_one"](1.0, c)])
    # Eight terms at 1 rad are exact to 1e-17; a few roundings of numbers below 1.
    return bool(np.allclose(*results, rtol=0, atol=1e-15))


def classical_updates_are_exact(kernels):
    """The velocity gained in a step is the dual rotation vector, corrected, in the axes of the start of the step."""
    p, b = (rows[:4] for rows in INCREMENTS)
    body = tuple(map(Series.of, START_BODY))
    with_transfer = exact_coefficients(PANOV_6)
    attitude = kernels["step"]((*START, body), p, b, with_transfer)[0]
    rotation = multiply(conjugated(START[0]), attitude)
    correction = cross(total(p), total(b))
    for rule in ((mpq(1, 2), mpq(0)), (mpq(1, 2), mpq(1, 6))):
        c = with_transfer._replace(resolving=rule)
        further = cross(total(p), correction)
        dual = kernels["rotation_vector_dual"](p, b, c)
        gain = [d + x * rule[0] + y * rule[1] for d, x, y in zip(dual, correction, further, strict=True)]
        expected = (
            attitude,
            [w + x for w, x in zip(START[1], turn(START[0], gain), strict=True)],
            turn(conjugated(rotation), [w + x for w, x in zip(body, gain, strict=True)]),
        )
        if not agree(kernels["step"]((*START, body), p, b, c), expected, DEGREE):
            return False
        state = kernels["compensated_step"]((START[0], NOTHING, START[1], NOTHING[:3]), p, b, c)
        if not agree(state, [expected[0], NOTHING, expected[1], NOTHING[:3]], DEGREE):
            return False
    return True


def polynomial_is_evaluated(kernels):
    """The last terms of the power series are too small to be missed elsewhere."""
    return kernels["polynomial"](mpq(10), (7, 5, 3, 2)) == 2357


CHECKS = (
    polynomial_is_evaluated,
    classical_updates_are_exact,
    batch_is_exact,
    carries_are_taken_back,
    summation_is_compensated,
    closed_forms_continue_the_series,
)


# Mutants of the source


class KernelPlanter(Planter):
    """Integers are indices: to a neighbour that exists, so that no mutant dies of a mere IndexError."""

    def changed(self, value):
        if type(value) is int:
            return abs(value - 1)
        return value * 1.001 or 1.0 if type(value) is float else None


def source_mutants():
    listing = KernelPlanter()
    rebuilt_kernels(listing.visit)
    return listing.places


MUTANTS = source_mutants()
EQUIVALENT = {
    # The second coefficient of a classical velocity update is zero or one sixth. With another condition its term is
    # computed, and is zero, or it is computed as before.
    "resolved_gain: c.resolving[1] != 0.0: 1 -> 0",
    "resolved_gain: c.resolving[1] != 0.0: 0.0 -> 1.0",
}


def test_the_kernels_pass_every_check():
    kernels = rebuilt_kernels()
    assert [check.__name__ for check in CHECKS if not check(kernels)] == []


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_the_methods_have_exactly_their_orders(method):
    assert coefficients_hold(method, rebuilt_kernels())


@pytest.mark.parametrize("target", range(len(MUTANTS)), ids=MUTANTS)
def test_source_mutant_is_found(target):
    detected = is_seen(
        lambda: rebuilt_kernels(KernelPlanter(target).visit), lambda kernels: all(check(kernels) for check in CHECKS)
    )
    assert detected != (MUTANTS[target] in EQUIVALENT)


# Mutants of the data

COEFFICIENTS = [
    (name, table, index)
    for name, method in METHODS.items()
    for table in ("pairs", "triples", "quartics")
    for index in getattr(method, table)
]


@pytest.mark.parametrize("defect", FACTORS)
@pytest.mark.parametrize(("name", "table", "index"), COEFFICIENTS)
def test_coefficient_mutant_is_found(name, table, index, defect):
    entries = dict(getattr(METHODS[name], table))
    entries[index] *= FACTORS[defect]
    assert not coefficients_hold(replace(METHODS[name], **{table: entries}), rebuilt_kernels())


def series_hold(cosine, sine, dual):
    """The identities in x = n^2 that define the three series C, S, D, coefficient by coefficient.

    C(0) = 1, C' = -S/4, S' = D/2 and x D = C/2 - S; of the first coefficients left out, the last two are found
    from the identities themselves.
    """
    terms = range(len(cosine))
    cosine = [*cosine, -sine[-1] / 4 / len(sine)]
    sine = [*sine, dual[-1] / 2 / len(dual)]
    return (
        cosine[0] == 1
        and cosine[0] / 2 == sine[0]
        and all((k + 1) * cosine[k + 1] == -sine[k] / 4 for k in terms)
        and all((k + 1) * sine[k + 1] == dual[k] / 2 for k in terms)
        and all(dual[k] == cosine[k + 1] / 2 - sine[k + 1] for k in terms)
    )


def test_the_series_obey_their_identities():
    assert series_hold(COSINE_SERIES, SINE_SERIES, DUAL_SERIES)


@pytest.mark.parametrize("defect", FACTORS)
@pytest.mark.parametrize("term", range(len(COSINE_SERIES)))
@pytest.mark.parametrize("position", range(3), ids=["cosine", "sine", "dual"])
def test_series_mutant_is_found(position, term, defect):
    series = [list(COSINE_SERIES), list(SINE_SERIES), list(DUAL_SERIES)]
    series[position][term] *= FACTORS[defect]
    assert not series_hold(*series)


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_binary64_coefficients_are_the_rounded_fractions(method):
    """What the exact checks above hold for is, correctly rounded, what the compiled kernels are given."""
    exact, rounded = exact_coefficients(method), binary64_coefficients(method)
    for name in Coefficients._fields:
        values = getattr(exact, name)
        if isinstance(values, tuple) and isinstance(values[0], Fraction):
            values = tuple(map(float, values))
        assert getattr(rounded, name) == values
