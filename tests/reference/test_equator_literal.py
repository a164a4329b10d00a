"""The closed form of the paper against the other form of the same solution."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import Arithmetic, MpArithmetic, Number
from sinsref.equator import COUPLED, EquatorModel, apply, homogeneous
from sinsref.equator import transition as robust_transition
from sinsref.equator_forced import Misalignment
from sinsref.equator_forced import solution as robust_solution
from sinsref.equator_literal import general_solution, north_response, particular_solution, solution, transition
from sinsref.equator_modes import NoRealModesError, modes
from sinsref.exact import ExactNumber
from sinsref.pi_monomials import PiMonomialArithmetic

INITIAL = ("0.01", "-0.02", "0.03", "1", "1.57e-7", "-2e-7")
TILT = (("1e-5", "2e-5", "-3e-5"), ("4e-5", "-5e-5", "6e-5"), ("7e-5", "8e-5", "-9e-5"))
#: Speeds, m/s, and heights, m, with real modes and away from every divisor: both directions, slow and fast.
MOTIONS = [("600", "10000"), ("10", "0"), ("-3000", "1e5"), ("7000", "0"), ("-8000", "20000"), ("2000", "4e5")]

# At 50 digits the divisors of these motions cost less than 6 digits, the growth to exp(13) another 6: 1e-36 is left
# with room to spare, while a wrong coefficient shows in the first digits.
TOLERANCE = 1e-36


def _model(ar: Arithmetic, speed: str, height: str) -> EquatorModel:
    return EquatorModel.at(ar, ExactNumber(speed), ExactNumber(height))


def _tilt(ar: Arithmetic, longitude: str = "0.7") -> Misalignment:
    return Misalignment([[ar.number(x) for x in row] for row in TILT], ar.number(longitude))


def _assert_close(computed: Sequence[Number], exact: Sequence[Number]) -> None:
    for x, y in zip(computed, exact, strict=True):
        assert abs(x - y) <= TOLERANCE * abs(y)


@pytest.mark.parametrize(("speed", "height"), MOTIONS)
@pytest.mark.parametrize("time", ["1", "600", "7200"])
def test_both_forms_of_the_solution_agree(speed: str, height: str, time: str) -> None:
    ar = MpArithmetic(50)
    model, initial, t = _model(ar, speed, height), [ar.number(x) for x in INITIAL], ar.number(time)
    m = modes(ar, model)
    exact = homogeneous(ar, model, initial, t)
    _assert_close(general_solution(ar, model, m, initial, t), exact)
    _assert_close(apply(transition(ar, model, m, t), initial), exact)
    _assert_close(solution(ar, model, initial, None, t), exact)
    literal, robust = transition(ar, model, m, t), robust_transition(ar, model, t)
    for i in range(6):
        _assert_close(literal[i], robust[i])


@pytest.mark.parametrize(("speed", "height"), MOTIONS)
@pytest.mark.parametrize("time", ["600", "7200"])
def test_both_answers_to_a_misalignment_agree(speed: str, height: str, time: str) -> None:
    ar = MpArithmetic(60)  # the series of the exact answer cancels as much as it grows
    model, initial, t = _model(ar, speed, height), [ar.number(x) for x in INITIAL], ar.number(time)
    tilt = _tilt(ar)
    _assert_close(solution(ar, model, initial, tilt, t), robust_solution(ar, model, initial, tilt, t))


@settings(derandomize=True, deadline=None, max_examples=40)
@given(speed=st.integers(-8300, 7300), height=st.integers(-10000, 10**6), time=st.integers(1, 20000))
def test_both_forms_agree_at_any_speed_with_modes(speed: int, height: int, time: int) -> None:
    ar = MpArithmetic(80)
    model, initial = _model(ar, str(speed), str(height)), [ar.number(x) for x in INITIAL]
    try:
        computed = solution(ar, model, initial, None, ar.number(time))
    except NoRealModesError:
        # The limits narrow with height.
        assert ar.sign(model.specific_force) <= 0
        return
    _assert_close(computed, homogeneous(ar, model, initial, ar.number(time)))


def test_the_matrix_is_one_at_the_start() -> None:
    ar = MpArithmetic(50)
    model = _model(ar, "600", "10000")
    matrix = transition(ar, model, modes(ar, model), ar.number(0))
    units = [abs(matrix[i][j] - int(i == j)) for i in range(6) for j in range(6)]
    # p26 multiplies by sqrt(g R), about 8e3, what cancels to 0.
    assert max(units) < 1e-40


def test_the_particular_solution_solves_the_equations() -> None:
    """Its derivative, by a difference quotient, is A x + b."""
    ar = MpArithmetic(60)
    model, tilt, t, step = _model(ar, "600", "10000"), _tilt(ar), ar.number(1234), ar.number("1e-15")
    at, later, before = (particular_solution(ar, model, tilt, t + k * step) for k in (0, 1, -1))
    force = tilt.force(ar, model, t)
    expected = [x + force[place] for x, place in zip(apply(model.coupled_matrix(ar), at), COUPLED, strict=True)]
    slope = [(x - y) / (2 * step) for x, y in zip(later, before, strict=True)]
    # The quotient is off by the third derivative times 1e-30 / 6.
    for x, y in zip(slope, expected, strict=True):
        assert abs(x - y) < 1e-28 * max(abs(z) for z in force)


@pytest.mark.parametrize("speed", ["-7.29e-5*6378245", "7450", "-8380", "9000"])
def test_without_real_modes_the_form_is_refused(speed: str) -> None:
    with PiMonomialArithmetic(256) as ar, pytest.raises(NoRealModesError):
        solution(ar, _model(ar, speed, "0"), [ar.number(x) for x in INITIAL], None, ar.number(60))


def test_at_the_resonance_of_the_north_channel_the_form_is_refused() -> None:
    with PiMonomialArithmetic(256) as ar:
        model = _model(ar, "6378245*(sqrt(9.78049/6378245) - 7.29e-5)", "0")
        with pytest.raises(ZeroDivisionError, match=r"omega\^2 - omega_N\^2"):
            north_response(ar, model, _tilt(ar), ar.number(60))


def test_fifteen_digits_are_the_bits_of_binary64() -> None:
    assert MpArithmetic(15).context.prec == 53
