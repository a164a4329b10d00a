"""Sine and cosine of the half-angle: power series, closed forms, and where one replaces the other."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsbench.subjects import kernels
from sinsbench.subjects.rotation_vector_methods import (
    COSINE_SERIES,
    DUAL_SERIES,
    PANOV_6,
    SERIES_LIMIT,
    SINE_SERIES,
    binary64_coefficients,
)

EPS = np.finfo(float).eps
MP = mpmath.MPContext()
MP.dps = 40


@given(st.floats(0.9, 1.0))
@settings(derandomize=True, deadline=None, max_examples=50)
def test_series_and_closed_forms_meet_at_the_limit(fraction):
    square = SERIES_LIMIT * fraction
    series, closed = (binary64_coefficients(PANOV_6, series_limit=limit) for limit in (SERIES_LIMIT, 0.0))
    np.testing.assert_allclose(kernels.half_angle(square, series), kernels.half_angle(square, closed), rtol=3 * EPS)
    less_one = [kernels.half_angle_cosine_less_one(square, c) for c in (series, closed)]
    np.testing.assert_allclose(less_one[0], less_one[1], rtol=4 * EPS)
    phi, phi_dual = (0.0, 0.0, square**0.5), (0.3, -0.2, 0.5)
    moments = [kernels.rotation_biquaternion(phi, phi_dual, c)[1] for c in (series, closed)]
    # The closed slope cancels from 0.5 to 0.04 there: an eps of 0.5, times d phi_i < 0.5.
    np.testing.assert_allclose(*moments, rtol=0, atol=2 * EPS)


@pytest.mark.parametrize("square", [0.0, 1e-300, 1e-8, 0.25, 1.0, 1.0000001, 9.0, 30.0])
def test_elementary_functions_are_accurate(square):
    coefficients = binary64_coefficients(PANOV_6)
    n = MP.sqrt(square)
    cosine, sine = kernels.half_angle(square, coefficients)
    assert cosine == pytest.approx(float(MP.cos(n / 2)), abs=2 * EPS)
    assert sine == pytest.approx(float(MP.sin(n / 2) / n) if square else 0.5, rel=3 * EPS)
    less_one = kernels.half_angle_cosine_less_one(square, coefficients)
    assert less_one == pytest.approx(float(MP.cos(n / 2) - 1), rel=4 * EPS)


def test_truncation_is_below_the_rounding():
    for series in (COSINE_SERIES, SINE_SERIES, DUAL_SERIES):
        following = abs(series[-1] ** 2 / series[-2])  # ratios of terms fall, so this bounds the next one
        assert following * Fraction(SERIES_LIMIT) ** len(series) < abs(series[0]) * Fraction(1, 10**17)
