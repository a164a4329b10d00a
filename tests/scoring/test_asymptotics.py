"""Asymptotic errors against the numbers of the specification's tables, and against other forms of the formulas."""

import numpy as np
import pytest

from sinsbench.scoring.asymptotics import ORDERS, predicted_error
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber
from sinsref.precession import DualPrecession

CASES = {case.name: case for case in paper_cases("dual_precession")}
DEG_PER_H = np.degrees(1) * 3600

# Order, motion: drift (deg/h); body and inertial velocity error (m/s) of variants 1-3, at t = 100 s and h = 0.01 s.
ASYMPTOTIC = {
    (4, "coning"): (0.1591278, (0.008598872, 0.08629573, 0.08653414), (0.008658852, 0.08765952, 0.08765952)),
    (4, "general"): (0.08203141, (0.00457406, 0.04595035, 0.04624659), (0.004615124, 0.04685011, 0.04685011)),
    (6, "coning"): (0.0003478137, (1.397004e-5, 0.0001406397, 0.0001413517), (1.414679e-5, 0.00014463, 0.00014463)),
    (6, "general"): (0.000837721, (4.597385e-5, 0.0004620484, 0.0004627868), (4.625379e-5, 0.0004684974, 0.0004684974)),
}


def norm(vectors):
    return float(np.linalg.norm(vectors[0]))


@pytest.mark.parametrize(("order", "motion"), ASYMPTOTIC)
@pytest.mark.parametrize("variant", [1, 2, 3])
def test_tabulated_values(order, motion, variant):
    drift, body, inertial = ASYMPTOTIC[order, motion]
    error = predicted_error(CASES[f"variant{variant}_{motion}"].motion, order, 0.01, [100.0])
    # The tables show seven digits, fewer where the last ones are zeros.
    assert norm(error.attitude) / 100 * DEG_PER_H == pytest.approx(drift, rel=2e-7)
    assert norm(error.velocity_body) == pytest.approx(body[variant - 1], rel=4e-7)
    assert norm(error.velocity_inertial) == pytest.approx(inertial[variant - 1], rel=4e-7)


def test_signed_components_between_whole_periods():
    """Order 6, eps = 1/2, t = 17.24 s, exact minus computed: the tabulated corrected values."""
    error = predicted_error(CASES["variant2_general"].motion, 6, 0.01, [17.24]).attitude[0]
    assert -error == pytest.approx([-2.64885e-8, -1.04875e-8, -7.00183e-8], rel=2e-6)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("eps", [-1.0, -0.3, 0.5, 2.0])
def test_secular_rate_is_the_reduced_polynomial(order, eps):
    """The combinations g + f cos(theta), reduced by hand."""
    nu, theta, h, time = 5.0, 0.4, 0.003, 7.0
    c = np.cos(theta)
    reduced = {
        2: 1.0,
        4: 7 - 4 * eps * c - 8 * eps**2,
        6: 89 - 282 * eps * c - 892 * eps**2 + 148 * eps**2 * c**2 - 652 * eps**3 * c - 192 * eps**4,
    }[order]
    delta = {2: 16 / 3, 4: 16 / 45, 6: 8 / 945}[order]
    motion = DualPrecession(*map(ExactNumber, (nu, eps, theta, 0, 0)), None, (ExactNumber(0),) * 3)
    found = predicted_error(motion, order, h, [time]).attitude[0, 2]
    expected = -delta * h**order / 4 * eps * nu ** (order + 1) * np.sin(theta) ** 2 * reduced * time
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_dual_part_is_the_derivative_along_the_dual_parameters(order):
    """The transfer principle, by central differences: truncation and rounding leave about 1e-9 of the derivative."""
    nu, theta, nu_dual, theta_dual, step = 4.0, 0.5, 0.7, 0.2, 1e-5
    zero = (ExactNumber(0),) * 3

    def at(k):
        parameters = (nu + k * nu_dual, -0.6, theta + k * theta_dual, 0, 0)
        motion = DualPrecession(*map(ExactNumber, parameters), None, zero)
        return predicted_error(motion, order, 0.01, [3.3]).attitude[0]

    dual = DualPrecession(*map(ExactNumber, (nu, -0.6, theta, nu_dual, theta_dual)), None, zero)
    found = predicted_error(dual, order, 0.01, [3.3]).attitude_dual[0]
    assert found == pytest.approx((at(step) - at(-step)) / (2 * step), rel=1e-7)


def test_a_fixed_axis_leaves_no_error():
    motion = DualPrecession(*map(ExactNumber, (5.0, 0, 0.4, 1, 2)), None, (ExactNumber(0),) * 3)
    error = predicted_error(motion, 4, 0.01, [1.0, 2.0])
    assert not error.velocity_inertial.any()


def test_unknown_order():
    with pytest.raises(ValueError, match="order = 3"):
        predicted_error(CASES["variant1_coning"].motion, 3, 0.01, [1.0])
