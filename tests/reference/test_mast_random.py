"""Elementary functions and normal numbers of fixed IEEE operations: accuracy against mpmath, and recorded bits."""

from __future__ import annotations

import ast
import hashlib
import inspect
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from types import ModuleType

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from sinsref import mast_elementary, mast_functions, mast_random, mast_running
from sinsref.mast_elementary import logarithm, sin_cos, sin_cos_of_turns, two_product, two_sum
from sinsref.mast_random import Stream, mixed, normals, words_of

Floats = NDArray[np.float64]
_MP = mpmath.MPContext()
_MP.prec = 200
_RANDOM = np.random.default_rng(20240001)
_COUNT = 1000
#: What numpy offers that IEEE 754, or the arithmetic of whole numbers, defines to the bit.
_ALLOWED = {
    "append", "arange", "array", "concatenate", "cumsum", "empty", "float64", "full", "full_like", "int64", "rint",
    "sqrt", "stack", "uint64", "where", "zeros", "zeros_like",
}  # fmt: skip


def _units(computed: Floats, exact: list[mpmath.mpf]) -> float:
    """Return the largest error in units in the last place of the exact value."""
    return max(
        float(abs(_MP.mpf(float(x)) - y) / float(np.spacing(abs(float(y))))) if y else float(x != 0) * np.inf
        for x, y in zip(computed, exact, strict=True)
    )


def _mp(values: Floats, function: Callable[[mpmath.mpf], mpmath.mpf]) -> list[mpmath.mpf]:
    return [function(_MP.mpf(float(x))) for x in values]


def test_sine_and_cosine_of_turns_are_within_a_unit_in_the_last_place() -> None:
    near_quarters = (np.arange(8, dtype=np.uint64) << np.uint64(61)) + np.uint64(3)
    turns = np.concatenate([_RANDOM.integers(0, 2**64, _COUNT, dtype=np.uint64), near_quarters])
    sine, cosine = sin_cos_of_turns(turns)
    angles = [2 * _MP.pi * int(x) / 2**64 for x in turns]
    assert _units(sine, [_MP.sin(x) for x in angles]) < 0.8
    assert _units(cosine, [_MP.cos(x) for x in angles]) < 0.8


def test_quarters_of_a_turn_are_exact() -> None:
    sine, cosine = sin_cos_of_turns(np.arange(4, dtype=np.uint64) << np.uint64(62))
    assert sine.tolist() == [0, 1, 0, -1]
    assert cosine.tolist() == [1, 0, -1, 0]


def test_sine_and_cosine_of_radians_are_within_a_unit_in_the_last_place() -> None:
    # Binary64 nearest to multiples of pi/2: where the reduction of the argument cancels most.
    angles = np.concatenate([_RANDOM.uniform(-1e3, 1e3, _COUNT), np.arange(-50, 51) * (np.pi / 2), [1e6, -1e6, 0.0]])
    sine, cosine = sin_cos(angles)
    assert _units(sine, _mp(angles, _MP.sin)) < 0.8
    assert _units(cosine, _mp(angles, _MP.cos)) < 0.8


def test_the_rest_of_an_angle_counts() -> None:
    angle, rest = np.array([0.7853981633974483]), np.array([5e-17])
    sine, _ = sin_cos(angle, rest)
    exact = _MP.sin(_MP.mpf(angle[0]) + _MP.mpf(rest[0]))
    assert _units(sine, [exact]) < 0.8
    assert _units(sin_cos(angle)[0], [exact]) < 1.5


def test_logarithms_are_within_a_unit_in_the_last_place() -> None:
    near_one = 1 - 2.0 ** -_RANDOM.uniform(1, 53, _COUNT // 2)
    powers = 2.0 ** -_RANDOM.uniform(0, 54, _COUNT // 2)
    values = np.concatenate([_RANDOM.uniform(0, 1, _COUNT), near_one, powers, [1.0, 2.0, 0.5, 2.0**-54]])
    assert _units(logarithm(values), _mp(values, _MP.ln)) < 0.8


_FLOATS = st.floats(-1e100, 1e100, allow_subnormal=False).filter(lambda x: x == 0 or abs(x) > 1e-100)


@settings(derandomize=True, deadline=None)
@given(_FLOATS, _FLOATS)
def test_sums_and_products_lose_nothing(a: float, b: float) -> None:
    x, y = np.array([a]), np.array([b])
    for (high, low), exact in (
        (two_sum(x, y), Fraction(a) + Fraction(b)),
        (two_product(x, y), Fraction(a) * Fraction(b)),
    ):
        assert Fraction(float(high[0])) + Fraction(float(low[0])) == exact


def test_words_are_those_of_whole_numbers() -> None:
    def mix(z: int) -> int:
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 % 2**64
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB % 2**64
        return z ^ (z >> 31)

    for seed, stream, first in ((0, 1, 0), (20240001, 6, 12345), (2**64 - 1, 7, 2**39)):
        wanted = [
            mix((mix(seed) + ((stream << 40) + k + 1) * 0x9E3779B97F4A7C15) % 2**64) for k in range(first, first + 5)
        ]
        assert words_of(seed, stream, first, 5).tolist() == wanted


def test_the_generator_is_splitmix64() -> None:
    """With key 0 in place of a mixed seed: the first outputs of the generator from state 0, as published."""
    counters = np.arange(1, 4, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    assert [f"{x:016x}" for x in mixed(counters).tolist()] == [
        "e220a8397b1dcdaf",
        "6e789e6aa1b965f4",
        "06c45d188009454f",
    ]


def test_first_normal_numbers() -> None:
    assert normals(20240001, Stream.ANTENNA_RATE, 0, 3) == pytest.approx(
        [0.18000506, 1.60096887, -0.13783785], abs=5e-9
    )
    assert normals(20240001, Stream.SATELLITES, 0, 2) == pytest.approx([-0.10377449, 1.57133253], abs=5e-9)


def test_normal_numbers_are_within_a_few_roundings() -> None:
    """Logarithm, root, cosine and two products: 0.5 units each, the root halves what comes before it."""
    words = words_of(7, 3, 0, _COUNT)
    uniform = [_MP.mpf(float(int(word) >> 11) + 0.5) / 2**53 for word in words]
    exact = []
    for first, second in zip(uniform[::2], uniform[1::2], strict=True):
        radius = _MP.sqrt(-2 * _MP.ln(first))
        exact += [radius * _MP.cos(2 * _MP.pi * second), radius * _MP.sin(2 * _MP.pi * second)]
    assert _units(normals(7, 3, 0, _COUNT), exact) < 2.5


def test_uniform_numbers_at_their_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    """All bits set round up to 1, none to 2^-54: the logarithm is 0, or the largest there is."""
    bits = {"all": 2**64 - 1, "none": 0}
    for first, second in (("all", "all"), ("none", "none"), ("all", "none"), ("none", "all")):
        words = np.array([bits[first], bits[second]], np.uint64)
        monkeypatch.setattr(mast_random, "words_of", lambda *_, known=words: known)
        assert normals(1, 1, 0, 2) == pytest.approx([0 if first == "all" else 8.652, 0], abs=1e-3)


def test_a_part_of_a_stream_is_that_part() -> None:
    whole = normals(5, 2, 0, 50)
    for first, end in pairwise((0, 1, 2, 7, 30, 33, 50)):
        assert np.array_equal(normals(5, 2, first, end - first), whole[first:end])


def test_streams_and_seeds_differ() -> None:
    parts = [normals(seed, stream, 0, 1000) for seed in (1, 2) for stream in Stream]
    correlations = np.corrcoef(parts) - np.eye(len(parts))
    # Five standard deviations of a correlation of 1000 pairs, 1/sqrt(1000).
    assert np.abs(correlations).max() < 0.16


def test_moments() -> None:
    """Mean, variance, skewness and excess within five of their own standard deviations."""
    z = normals(20240001, Stream.FORCE_2, 0, 300_000)
    moments = [z.mean(), z.var() - 1, (z**3).mean(), (z**4).mean() - 3]
    assert all(abs(x) < 5 * np.sqrt(v / len(z)) for x, v in zip(moments, (1, 2, 15, 96), strict=True))
    # Beyond 4.5 standard deviations: 2.04 are expected.
    assert 0 < (np.abs(z) > 4.5).sum() < 12


def test_bits_are_those_recorded() -> None:
    """Recorded on x86-64, numpy 2: not correctly rounded, so the bits belong to this sequence of operations alone."""
    digest = hashlib.sha256()
    for stream in Stream:
        digest.update(normals(20240001, stream, 0, 3000).astype("<f8").tobytes())
    assert digest.hexdigest() == "35cb30d4cb94a084cc6b1fa2228df5bd5fba37970f9d10f05727bd0ab4f7fa8b"


@pytest.mark.parametrize(
    "module", [mast_elementary, mast_random, mast_running, mast_functions], ids=lambda m: m.__name__
)
def test_nothing_of_a_library_of_elementary_functions_is_used(module: ModuleType) -> None:
    used = {
        node.attr
        for node in ast.walk(ast.parse(inspect.getsource(module)))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "np"
    }
    assert used <= _ALLOWED
