"""Operations counted by running a function's own source: against counts by hand, and where counting must give up."""

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.spatial.transform import Rotation

from sinsbench.instrumentation import UncountableError, count_operations, operations_per_sample
from sinsbench.subjects import kernels
from sinsbench.subjects.integrators import INTEGRATORS, attitude_only
from sinsbench.subjects.registry import BUILT_IN
from sinsbench.subjects.rotation_vector_methods import PANOV_2, PANOV_4, binary64_coefficients

RANDOM = np.random.default_rng(3)
ANGLE, VELOCITY = RANDOM.normal(scale=0.05, size=(60, 3)), RANDOM.normal(size=(60, 3))


def inputs(samples):
    return ANGLE[:samples], VELOCITY[:samples], 0.01, np.array([1.0, 0, 0, 0]), np.array([1.0, 2.0, 3.0])


def test_counts_are_those_counted_by_hand():
    """Order 2, attitude alone, one step of 4 samples.

    Sum of 4 vectors: 9 additions. Square of the angle: 3 products, 2 additions. Two series of 8 terms: 7
    products and 7 additions each. Vector part: 3 products. Quaternion product: 16 products, 12 additions.
    """
    increments = tuple(map(tuple, ANGLE[:4].tolist()))
    counts = count_operations(kernels.attitude_step, (1.0, 0.0, 0.0, 0.0), increments, binary64_coefficients(PANOV_2))
    assert counts == {"add": 9 + 2 + 14 + 12, "multiply": 3 + 14 + 3 + 16}
    assert operations_per_sample(attitude_only(PANOV_2), inputs, 4) == (sum(counts.values()) / 4, "")


def test_order_4_adds_its_four_vector_products_to_order_2():
    """Each is 6 products and 3 additions, times its coefficient (3), added to the sum (3)."""
    (second, _), (fourth, _) = (
        operations_per_sample(attitude_only(method), inputs, 4) for method in (PANOV_2, PANOV_4)
    )
    assert fourth - second == 4 * (6 + 3 + 3 + 3) / 4


def test_closed_forms_cost_a_root_a_sine_and_a_cosine():
    closed = binary64_coefficients(PANOV_4, series_limit=0.0)
    counts = count_operations(kernels.half_angle, 0.3, closed)
    assert counts == {"cos": 1, "divide": 1, "multiply": 1, "sin": 1, "sqrt": 1}


@pytest.mark.parametrize("name", INTEGRATORS)
def test_every_step_costs_the_same_and_the_same_twice(name):
    samples = BUILT_IN[name].samples_per_step
    found = [operations_per_sample(INTEGRATORS[name], inputs, samples) for _ in range(2)]
    assert found[0] == found[1]
    assert found[0][0] > 0
    assert found[0][1] == ""


def by_rows(angle, velocity, interval, attitude0, velocity0):
    """The same work as `at_once`, a row at a time, into an array."""
    result = np.empty((len(angle) + 1, 4))
    result[0] = attitude0
    for i in range(len(angle)):
        result[i + 1, 1:] = 0.5 * angle[i] + np.cross(angle[i], velocity[i])
        result[i + 1, 0] = math.sqrt(1.0 - result[i + 1, 1:] @ result[i + 1, 1:])
    return result


def at_once(angle, velocity, interval, attitude0, velocity0):
    vector = angle / 2
    vector += np.cross(angle, velocity)
    scalar = np.sqrt(1.0 - np.einsum("ij,ij->i", vector, vector))
    return np.vstack([attitude0, np.column_stack([scalar, vector])])


def test_rows_and_whole_arrays_cost_the_same():
    """Half (3), vector product (9), sum (3), square (5), difference and root (2): 22, with a state kept in an array."""
    assert operations_per_sample(by_rows, inputs, 1) == (22.0, "")
    assert operations_per_sample(at_once, inputs, 1) == (22.0, "")


class Quaternion:
    def __init__(self, scalar, vector):
        self.scalar, self.vector = scalar, np.array(vector)

    def __mul__(self, other):
        scalar = self.scalar * other.scalar - self.vector @ other.vector
        vector = self.scalar * other.vector + other.scalar * self.vector + np.cross(self.vector, other.vector)
        return Quaternion(scalar, vector)


class Pair(NamedTuple):
    x: float
    y: float

    def total(self):
        return self.x + self.y


@dataclass
class Scaled:
    factor: float

    def __call__(self, x):
        return self.factor * x


@njit
def compiled_norm(x):
    total = 0.0
    for i in range(x.shape[0]):
        total += x[i] * x[i]
    return math.sqrt(total)


def raised(x):
    return x + 1.0


@functools.lru_cache
def kept(x):
    return x * 2.0


def in_place():
    array = np.ones((4, 3))
    row = array[0]
    array[1:] += array[:-1] * 2.0
    index = iter([0, 1])
    array[next(index)] *= 3.0
    row -= 1.0  # a view: the array changes too
    assert array[0].tolist() == [2.0] * 3
    assert next(index) == 1
    return array


def closures():
    factor = 2.0

    def twice(x, *, shift=1.0):
        return factor * x + shift

    return twice(1.0) + functools.partial(twice, shift=0.0)(2.0) + (lambda x: x - 1.0)(5.0)


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (lambda: Quaternion(1.0, ANGLE[0]) * Quaternion(0.5, ANGLE[1]), {"add": 12, "multiply": 16}),
        (lambda: Pair(1.0, 2.0).total(), {"add": 1}),
        (lambda: Scaled(2.0)(3.0), {"multiply": 1}),
        (lambda: compiled_norm(ANGLE[:, 0][:5]), {"add": 5, "multiply": 5, "sqrt": 1}),
        (in_place, {"add": 12, "multiply": 12}),
        (closures, {"add": 5, "multiply": 2}),
        (lambda: [kept(7.0), kept(7.0)], {}),
        (lambda: sum(x * 2.0 for x in [1.0, 2.0, 3.0]), {"add": 3, "multiply": 3}),
        (lambda: list(map(raised, [1.0, 2.0])), {"add": 2}),
        (lambda: ANGLE[:2] @ ANGLE[:3].T, {"add": 12, "multiply": 18}),
        (lambda: np.dot(ANGLE[0], ANGLE[1]), {"add": 2, "multiply": 3}),
        (lambda: np.einsum("nij,nj->ni", np.ones((2, 3, 3)), ANGLE[:2]), {"add": 12, "multiply": 18}),
        (lambda: np.linalg.norm(ANGLE[:5], axis=1), {"add": 10, "multiply": 15, "sqrt": 5}),
        (lambda: np.cumsum(ANGLE[:5], axis=0), {"add": 12}),
        (lambda: np.add.reduce(ANGLE[:5, 0]) + ANGLE[:5].sum(axis=0), {"add": 4 + 12 + 3}),
        (lambda: np.mean(ANGLE[:4], axis=0), {"add": 9, "divide": 3}),
        (lambda: np.diff(ANGLE[:4], axis=0), {"add": 9}),
        (lambda: np.sinc(ANGLE[0]), {"divide": 3, "multiply": 3, "sin": 3}),
        (lambda: (ANGLE[0] ** 2, ANGLE[0, 0] ** 3, abs(ANGLE[0, 0]) ** 0.5), {"multiply": 5, "sqrt": 1}),
        (lambda: np.maximum(-np.abs(ANGLE), 0)[::2] > 3 // 2, {}),
        (lambda: len(ANGLE) * 3 + 7 % 4, {}),
        (lambda: np.arctan2(ANGLE[0, 0], math.hypot(ANGLE[0, 1], 1.0)), {"arctan2": 1, "hypot": 1}),
    ],
)
def test_what_code_of_many_kinds_costs(function, expected):
    plain = function()
    assert plain is not None
    assert count_operations(function) == expected


@pytest.mark.parametrize(
    ("function", "says"),
    [
        (lambda: Rotation.from_rotvec(ANGLE[0]), "scipy"),
        (lambda: np.linalg.inv(np.eye(3)), "numpy.inv is compiled"),
        (lambda: np.fft.fft(np.ones(4)), "numpy.fft|complex"),
        (lambda: complex(ANGLE[0, 0]) * 2.0, "complex"),
        (lambda: np.array([1, 2.5], dtype=object) * 2, "object"),
        (lambda: eval("1.0 + 2.0"), "eval"),
        (lambda: np.linalg.norm(ANGLE, 1), "Euclidean"),
    ],
)
def test_code_that_cannot_be_followed_is_told(function, says):
    with pytest.raises(UncountableError, match=says):
        count_operations(function)


def test_an_except_clause_of_the_subject_does_not_hide_it():
    def careful(*_):
        try:
            return Rotation.from_rotvec(ANGLE[0])
        except Exception:
            return None

    count, note = operations_per_sample(careful, inputs, 1)
    assert count is None
    assert "scipy" in note


def test_steps_of_different_cost_and_failures_are_told():
    def growing(angle, *_):
        return np.outer(angle[:, 0], angle[:, 0])

    def quits(*_):
        raise SystemExit("bye")

    assert operations_per_sample(growing, inputs, 1) == (None, "a step costs now 7, now 9 operations")
    assert operations_per_sample(quits, inputs, 1) == (None, "counting raises SystemExit")


@given(st.integers(1, 6), st.integers(1, 6), st.integers(1, 6))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_products_of_matrices_cost_their_definition(m, k, n):
    a, b = np.ones((m, k)), np.ones((k, n))
    expected = {"multiply": m * n * k, "add": m * n * (k - 1)}
    expected = {kind: count for kind, count in expected.items() if count}
    for product in (np.matmul, np.dot, lambda x, y: x @ y, lambda x, y: np.einsum("ij,jk->ik", x, y)):
        assert count_operations(product, a, b) == expected
