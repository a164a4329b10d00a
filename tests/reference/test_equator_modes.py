"""The modes of the error equations: constants (17), the general solution (16), amplitudes and phases (18)-(19)."""

import pytest
from flint import arb, arb_mat
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic
from sinsref.equator import EquatorModel, homogeneous
from sinsref.equator_modes import (
    NoRealModesError,
    constants_of_integration,
    modes,
    oscillations,
    vanishing_force_speeds,
)
from sinsref.exact import ExactNumber
from sinsref.pi_monomials import PiMonomialArithmetic

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=40)
BITS = 256
# Away from omega_N = 0 (-464.97 m/s), where the modes lose digits without bound.
speeds = st.one_of(st.floats(-8000, -466), st.floats(-463, 7000))
states = st.tuples(*[st.floats(-1, 1)] * 3, st.floats(-100, 100), *[st.floats(-1e-5, 1e-5)] * 2)

CONSTANTS = {
    ("600", "10000"): {
        "gravity": "9.7498936940287", "specific_force": "9.60606018848845", "frame_rate": "1.66822509233757e-4",
        "coriolis_rate": "2.39722509233757e-4", "a24": "3.04362683061109e-6", "rho1": "3.00080541077581e-6",
        "rho2": "-1.54086959577398e-6", "alpha3_growing": "-1.28344250521006e-4",
        "alpha3_swinging": "-0.0137406410185365", "alpha6": "-2.0085101810779e-8", "nu": "1.74462043587065e-6",
        "beta3": "0.0017322832940301", "omega": "0.0012354044415397", "mu": "0.0012413176852740",
    },
    ("10", "0"): {
        "gravity": "9.78049", "specific_force": "9.77901632170605", "frame_rate": "7.44678293950765e-5",
        "coriolis_rate": "1.47367829395077e-4", "a24": "3.06682548596143e-6", "rho1": "3.05229379545581e-6",
        "rho2": "-1.54059955866022e-6", "alpha3_growing": "-9.7570257006673e-5",
        "alpha3_swinging": "-0.0309356743848255", "alpha6": "-8.89664307727646e-9", "nu": "3.90782867807572e-6",
        "beta3": "0.0017470815079600", "omega": "0.0012383109351149", "mu": "0.0012412089101599",
    },
}  # fmt: skip


def at(ar, v_east, height="0"):
    return EquatorModel.at(ar, ExactNumber(v_east), ExactNumber(height))


@pytest.mark.parametrize(("case", "table"), CONSTANTS.items())
def test_constants_to_the_printed_digits(case, table):
    with BallArithmetic(BITS) as ar:
        model = at(ar, *case)
        found = modes(ar, model)
        for name, digits in table.items():
            value = getattr(found, name, None)
            value = getattr(model, name) if value is None else value
            mantissa, _, exponent = digits.partition("e")
            last = arb(10) ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
            assert abs(value - arb(digits)) < last * 0.501, name
        assert found.omega.overlaps(model.schuler_rate)


@deterministic
@given(speeds, st.floats(-1e4, 1e5))
def test_modes_are_eigenvectors(v_east, height):
    with BallArithmetic(BITS) as ar:
        model = at(ar, v_east, height)
        m = modes(ar, model)
        matrix = arb_mat(model.coupled_matrix(ar))
        # Growing and decaying: (+-beta3, A3, 1, +-A6); real and imaginary part of the oscillation.
        for sign in (1, -1):
            vector = arb_mat(4, 1, [sign * m.beta3, m.alpha3_growing, 1, sign * m.alpha6])
            residual = matrix * vector - vector * (sign * m.beta3)
            assert all(x.contains(0) and x.rad() < 1e-60 for x in residual.entries())
        real = arb_mat(4, 1, [0, m.alpha3_swinging, 1, 0])
        imaginary = arb_mat(4, 1, [m.mu, 0, 0, m.nu])
        for residual in (matrix * real + imaginary * m.mu, matrix * imaginary - real * m.mu):
            assert all(x.contains(0) and x.rad() < 1e-60 for x in residual.entries())
        assert (m.rho1 * m.rho2 + model.q).contains(0)
        assert (m.alpha6 - (m.alpha3_growing - model.v_east / model.radius) / (model.radius * m.beta3)).contains(0)


def general_solution(ar, model, m, initial, t):
    """Equation (16), written out."""
    c1, c2, c3, c4, c5, c6 = constants_of_integration(ar, model, m, initial)
    sw, cw = ar.sin_cos(m.omega * t)
    sm, cm = ar.sin_cos(m.mu * t)
    grow, fall = ar.exp(m.beta3 * t), ar.exp(-m.beta3 * t)
    s = ar.sqrt(model.gravity * model.radius)
    return [
        s * (c2 * cw - c1 * sw),
        m.beta3 * (c3 * grow - c4 * fall) + m.mu * (c6 * cm - c5 * sm),
        m.alpha3_growing * (c3 * grow + c4 * fall) + m.alpha3_swinging * (c5 * cm + c6 * sm),
        c3 * grow + c4 * fall + c5 * cm + c6 * sm,
        c1 * cw + c2 * sw,
        m.alpha6 * (c3 * grow - c4 * fall) + m.nu * (c6 * cm - c5 * sm),
    ]


@deterministic
@given(speeds, st.floats(-1e4, 1e5), states, st.floats(-3600, 7200))
def test_the_general_solution_is_the_transition_matrix(v_east, height, initial, time):
    with BallArithmetic(BITS) as ar:
        model = at(ar, v_east, height)
        start = [ar.number(x) for x in initial]
        found = general_solution(ar, model, modes(ar, model), start, arb(time))
        expected = homogeneous(ar, model, start, arb(time))
        assert all(x.overlaps(y) for x, y in zip(found, expected, strict=True))
        assert max(float((x - y).abs_upper()) for x, y in zip(found, expected, strict=True)) < 1e-45


@deterministic
@given(speeds, states, st.floats(0, 7200))
def test_amplitudes_and_phases_make_the_oscillating_part(v_east, initial, time):
    with BallArithmetic(BITS) as ar:
        model = at(ar, v_east)
        m, start, t = modes(ar, model), [ar.number(x) for x in initial], arb(time)
        _, _, c3, c4, *_ = constants_of_integration(ar, model, m, start)
        grow, fall = ar.exp(m.beta3 * t) * c3, ar.exp(-m.beta3 * t) * c4
        even, odd = grow + fall, grow - fall
        steady = [0, m.beta3 * odd, m.alpha3_growing * even, even, 0, m.alpha6 * odd]
        rates = [m.omega, m.mu, m.mu, m.mu, m.omega, m.mu]
        expected = homogeneous(ar, model, start, t)
        for part, rate, rest, x in zip(oscillations(ar, model, m, start), rates, steady, expected, strict=True):
            if part is None:
                swing = arb(0)
            else:
                sine, cosine = ar.sin_cos(rate * t)
                swing = part.amplitude * (sine * part.cosine + cosine * part.sine)
                assert (part.sine**2 + part.cosine**2 - 1).contains(0)
            assert abs(x - rest - swing) < 1e-45


@pytest.mark.parametrize(
    ("place", "value", "expected"),
    [  # Tables 2 and 3: fighter (600 m/s, 10 km), sets II and III of initial errors
        (4, "1.57e-7", [("-0.001239054400723", "0"), None, None, None, ("1.57e-7", "pi/2"), None]),
        (5, "1.57e-7", [None, ("1.107933124949e-4", "pi/2"), ("-0.001226415407037", "0"),
                        ("0.08925459921285", "0"), None, ("1.557153977822e-7", "pi/2")]),
    ],
)  # fmt: skip
def test_signed_amplitudes_are_those_of_the_tables(place, value, expected):
    with PiMonomialArithmetic(BITS) as ar:
        model = at(ar, "600", "10000")
        start = [ar.number(value if i == place else 0) for i in range(6)]
        for part, entry in zip(oscillations(ar, model, modes(ar, model), start), expected, strict=True):
            assert (part is None) == (entry is None)
            if part is not None:
                amplitude, phase = part.signed(ar)
                # The phases pi/2 and 0 with a signed amplitude stand for the same oscillation as pi/2 + pi, pi.
                assert (float(amplitude), phase) == (pytest.approx(float(entry[0]), rel=1e-12), entry[1])


def test_a_phase_between_is_not_a_table_entry():
    with BallArithmetic(BITS) as ar:
        model = at(ar, "600")
        part = oscillations(ar, model, modes(ar, model), [ar.number(x) for x in (1, 1, 1, 1, 1, 1)])[0]
        with pytest.raises(ValueError, match="multiple of pi/2"):
            part.signed(ar)


@pytest.mark.parametrize("v_east", ["-7.29e-5*6378245", "7447", "8000", "-8380"])
def test_without_real_modes_there_are_no_constants(v_east):
    with PiMonomialArithmetic(BITS) as ar, pytest.raises(NoRealModesError):
        modes(ar, at(ar, v_east))


@pytest.mark.parametrize(
    ("height", "east"), [("0", "7446.951262516"), ("100000", "7379.006105565"), ("1000000", "6825.329374368")]
)
def test_speeds_of_vanishing_specific_force(height, east):
    with BallArithmetic(BITS) as ar:
        low, high = vanishing_force_speeds(ar, ExactNumber(height))
        assert abs(high - arb(east)) < 0.501e-9
        for v in (low, high):
            radius = 6378245 + arb(height)
            u, g = arb("7.29e-5"), arb("9.78049") * arb(6378245) ** 2 / radius**2
            force = g - 2 * u * v - v * v / radius
            assert force.contains(0)
            assert force.rad() < 1e-60
        if height == "0":
            assert abs(low + arb("8376.90")) < 0.00501
