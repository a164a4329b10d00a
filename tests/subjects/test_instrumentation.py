from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsbench.instrumentation import reduced_precision_integrator, round_mantissa
from sinsbench.subjects.integrators import panov4, panov6
from sinsbench.subjects.rotation_vector_methods import PANOV_2, PANOV_4, PANOV_6

RANDOM = np.random.default_rng(1989)
ANGLE = RANDOM.normal(scale=0.05, size=(400, 3))
VELOCITY = RANDOM.normal(scale=0.3, size=(400, 3))
ATTITUDE = np.array([0.5, 0.5, -0.5, 0.5])
INPUTS = (ANGLE, VELOCITY, 0.01, ATTITUDE, np.array([10.0, -20.0, 5.0]))


def exactly_rounded(value, bits, rounding):
    """The definition, in rational arithmetic."""
    exact = Fraction(value)
    exponent = 0
    while abs(exact) >= 2**bits:
        exact, exponent = exact / 2, exponent + 1
    while exact and abs(exact) < 2 ** (bits - 1):
        exact, exponent = exact * 2, exponent - 1
    whole = round(exact) if rounding == "nearest" else int(exact)  # round: ties to even; int: towards zero
    return float(whole * Fraction(2) ** exponent)


@settings(deadline=None)  # the first call compiles
@given(
    st.floats(-1e100, 1e100).filter(lambda x: x == 0 or abs(x) > 1e-100),
    st.integers(2, 53),
    st.sampled_from(["nearest", "chop"]),
)
def test_rounding_is_that_of_the_definition(value, bits, rounding):
    assert round_mantissa(value, bits, rounding) == exactly_rounded(value, bits, rounding)


@pytest.mark.parametrize(("value", "expected"), [(5.0, 4.0), (7.0, 8.0), (-5.0, -4.0), (-7.0, -8.0)])
def test_ties_go_to_even(value, expected):
    assert round_mantissa(value, 2) == expected


def test_rounding_does_not_touch_its_argument():
    values = np.array([1.0, 1 / 3])
    assert round_mantissa(values, 10)[1] != values[1] == 1 / 3


@pytest.mark.parametrize(("bits", "rounding"), [(1, "nearest"), (54, "nearest"), (40, "up")])
def test_inadmissible_arithmetic_is_refused(bits, rounding):
    with pytest.raises(ValueError, match="expected"):
        reduced_precision_integrator(PANOV_6, bits, rounding)


def test_at_53_bits_the_emulation_is_the_integrator():
    emulated = reduced_precision_integrator(PANOV_6, 53, elementary="series")(*INPUTS)
    for name, values in panov6(*INPUTS).items():
        np.testing.assert_array_equal(emulated[name], values)


@pytest.mark.parametrize("rounding", ["nearest", "chop"])
def test_every_result_has_the_mantissa_asked_for(rounding):
    for values in reduced_precision_integrator(PANOV_6, 36, rounding)(*INPUTS).values():
        np.testing.assert_array_equal(round_mantissa(values, 36, rounding), values)


def test_at_24_bits_the_emulation_is_binary32_arithmetic():
    """Sums, products and quotients of binary32 numbers are doubly rounded through binary64 without harm."""
    single = np.float32
    angle, velocity = ANGLE[:4].astype(single), VELOCITY[:4].astype(single)
    rotation = angle[0] + angle[1] + angle[2] + angle[3]
    square = rotation[0] * rotation[0] + rotation[1] * rotation[1] + rotation[2] * rotation[2]
    n = np.sqrt(square)
    half = single(0.5) * n
    vector = single(np.sin(np.float64(half))) / n * rotation
    quaternion = [single(np.cos(np.float64(half))), *vector]
    emulate = reduced_precision_integrator(PANOV_2, 24)
    result = emulate(angle, velocity, 0.01, [1.0, 0.0, 0.0, 0.0], np.zeros(3))
    np.testing.assert_array_equal(result["attitude"][1], quaternion)


def test_error_halves_with_each_bit_more():
    exact = panov4(*INPUTS)["attitude"]
    bits = np.arange(26, 45)
    errors = [np.abs(reduced_precision_integrator(PANOV_4, b)(*INPUTS)["attitude"] - exact).max() for b in bits]
    slope = np.polyfit(bits, np.log2(errors), 1)[0]
    # The errors of 100 steps are a random sum: its size scatters by a factor of about two from one b to the
    # next, which moves the slope over 18 bits by some 0.05.
    assert slope == pytest.approx(-1, abs=0.1)
