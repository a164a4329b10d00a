"""The formulas of the paper for the errors along the equator: what they give, and where they fail."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from equator_errors import (
    EPS,
    FIGHTER,
    GENERAL,
    INITIAL,
    SHIP,
    SINGULAR,
    STATIONARY,
    V_MAX,
    end_state,
    exact_state,
    matrix_error,
    state_error,
)
from sinsbench.subjects import equator_formulas, equator_robust
from sinsbench.subjects.equator_model import EARTH_RATE, EquatorMotion, NotApplicableError


@given(v_east=st.floats(-8300, 7400), height=st.floats(-5000, 2e4))
def test_corrected_matrix_starts_at_identity(v_east, height):
    # Each element is a sum divided by the same two products: a few roundings, or an exact zero.
    try:
        matrix = equator_formulas.transition_matrix([0.0], v_east, height)[0]
    except NotApplicableError:
        assert abs(v_east - STATIONARY) < 1
        return
    np.testing.assert_allclose(matrix, np.eye(6), rtol=8 * EPS, atol=0)


def test_printed_matrix_does_not_start_at_identity():
    matrix = equator_formulas.transition_matrix([0.0], *FIGHTER, edition="printed")[0]
    assert matrix[1, 1] - 1 == pytest.approx(-0.00409109, rel=1e-5)
    assert matrix[1, 5] == pytest.approx(-352.845, rel=1e-5)
    assert np.array_equal(np.delete(matrix, 1, axis=0), np.delete(np.eye(6), 1, axis=0))


REGULAR_SUBJECTS = [
    equator_formulas.corrected,
    equator_formulas.general_solution,
    equator_formulas.amplitude_phase,
    equator_robust.robust,
]


@pytest.mark.parametrize("subject", REGULAR_SUBJECTS, ids=lambda subject: subject.__name__)
@pytest.mark.parametrize("motion", [FIGHTER, SHIP])
@pytest.mark.parametrize("misaligned", [False, True])
def test_closed_forms_at_the_motions_of_the_paper(subject, motion, misaligned):
    for time in (3600.0, 7200.0):
        state = end_state(subject, motion, time, misaligned)
        # 1-2 digits beyond the last are lost in the exponent up to 7200 s.
        assert state_error(state, motion, time, misaligned=misaligned) < 20 * EPS


LITERAL_ERRORS = {  # (speed, largest of the errors measured at 3600 s and 7200 s, rounded up): known losses
    "at rest": (0.0, 2e-15),
    "2u + v/R = 0": (2 * STATIONARY, 1e-15),
    "1 m/s from omega_N = 0": (STATIONARY + 1, 7e-13),
    "1 mm/s from omega_N = 0": (STATIONARY + 1e-3, 2e-10),
    "1 m/s below a_H = 0": (V_MAX - 1, 9e-14),
    "1 um/s below a_H = 0": (V_MAX - 1e-6, 5e-8),
}


@pytest.mark.parametrize("name", LITERAL_ERRORS)
def test_literal_formula_loses_the_known_digits(name):
    speed, figure = LITERAL_ERRORS[name]
    errors = [
        matrix_error(equator_formulas.transition_matrix([t], speed, 0.0)[0], (speed, 0.0), t) for t in (3600.0, 7200.0)
    ]
    # The loss is rounding, so it is known to a factor of a few; three on either side.
    assert figure / 5 < max(errors) < 3 * figure


@pytest.mark.parametrize(
    ("v_east", "sentence"),
    [
        (STATIONARY, "divide by omega_N"),
        (V_MAX + 1, "modes are not real"),
        (8000.0, "complex"),
        (-8380.0, "modes are not real"),
    ],
)
def test_literal_formula_says_where_it_fails(v_east, sentence):
    with pytest.raises(NotApplicableError, match=sentence):
        equator_formulas.corrected([1.0], v_east, 0.0, INITIAL)


def test_printed_edition_errs_only_in_the_vertical_velocity():
    time = np.linspace(0.0, 7200.0, 7201)
    printed = equator_formulas.printed(time, *FIGHTER, INITIAL)
    difference = printed - equator_formulas.corrected(time, *FIGHTER, INITIAL)
    assert not difference[:, [0, 2, 3, 4, 5]].any()
    # Half of the oscillation of dv_H.  One-second sampling misses its crest by at most 4e-7 of it.
    assert np.abs(difference[:, 1]).max() == pytest.approx(4.717418156e-4, rel=1e-6)
    modes = equator_formulas.modal_constants(*FIGHTER)
    amplitude, _ = equator_formulas.amplitudes_and_phases(modes, INITIAL)
    assert amplitude[1] / 2 == pytest.approx(4.717418156e-4, rel=1e-9)
    crests = time[1:-1][np.diff(np.sign(np.diff(difference[:, 1]))) != 0]
    np.testing.assert_allclose(crests, [1100, 3630, 6160], atol=5)
    exact = float(exact_state(FIGHTER, 7200.0)[1])
    assert exact - printed[-1, 1] == pytest.approx(1.311e-4, rel=1e-3)


def test_principal_value_reverses_a_phase_in_the_left_half_plane():
    initial = (0.0, 0.0, 0.0, 0.0, 1e-6, 0.0)
    time = np.linspace(0.0, 7200.0, 50)
    printed = equator_formulas.amplitude_phase_printed(time, *SHIP, initial)
    corrected = equator_formulas.amplitude_phase(time, *SHIP, initial)
    # tan(eps) = 0 stands for eps = pi; sin(pi) in float64 shifts the phase by 1e-16.
    np.testing.assert_allclose(printed[:, 0], -corrected[:, 0], atol=4 * EPS * np.abs(corrected[:, 0]).max())
    np.testing.assert_allclose(printed[:, 4], corrected[:, 4], atol=4e-6 * EPS)


def test_amplitudes_of_the_tables():
    # Sets I and III of Table 2, recomputed to 13 digits, in the order dv_H, dv_E, dH, dlam.
    modes = equator_formulas.modal_constants(*FIGHTER)
    height, _ = equator_formulas.amplitudes_and_phases(modes, (0, 0, 0, 1, 0, 0))
    expected = [1.170382858162e-5, 1.295543509855e-4, 9.428552191323e-3, 1.644924483365e-8]
    np.testing.assert_allclose(np.abs(height[[1, 2, 3, 5]]), expected, rtol=1e-12)
    rest, _ = equator_formulas.amplitudes_and_phases(modes, (0, 0, 0, 0, 0, 1.57e-7))
    assert rest[5] == pytest.approx(1.557153977822e-7, rel=1e-12)


# P(t) at 20 digits for the two motions of the paper, row by row of the nonzero elements.
ELEMENTS = "11 15 22 23 24 26 32 33 34 36 42 43 44 46 51 55 62 63 64 66"
REFERENCE = {
    (FIGHTER, 3600.0): """-0.26184459752558476752 7616.7124422787727074 253.37050922065341051
        32.421109564274824544 0.44669148334069512951 -180447.7038959804277 -18.684236171965733196
        -2.6521600680940432568 -0.033127561476988772257 20937.439193150304879 146257.52127341931876
        18784.777562837089059 257.87364323341469007 -104620185.01602282409 -0.00012228864011938417251
        -0.26184459752558476752 -0.0029405224068327199504 -0.00050131500632600641 -5.1952964285984060539e-6
        1.8509739446672362983""",
    (FIGHTER, 7200.0): """-0.86287481349332905489 -3988.7900078331980789 129453.45091860172252
        16610.028363238071336 228.23185582032102884 -92108261.244217467241 -9591.2028847581316824
        -1231.5198410353047751 -16.909730747614829441 6820564.3413920305673 74729961.28128680349
        9588557.5810358382681 131752.04400185999396 -53170966255.713902692 0.000064041239508022454054
        -0.86287481349332905489 -1.5009689799054103698 -0.19252584028581770413 -0.0026462453480576341324
        1067.0732422229666663""",
    (SHIP, 3600.0): """-0.25173213808607072331 7643.9027500372233988 269.00558179034403656
        15.225573836589235988 0.47221782701687635164 -85518.597604423327573 -14.984171757951686137
        -1.0948847483796882749 -0.026396262357415466374 12441.065539680638826 153972.16010595591522
        8745.112472570629183 270.29433003324258105 -49153123.983607871079 -0.00012253307783776478893
        -0.25173213808607072331 -0.0013710844397746761347 -0.00020069800854708024318
        -2.4166866516747954967e-6 0.19386349451885622131""",
    (SHIP, 7200.0): """-0.87326186130923084319 -3848.4319651777321288 144961.51250569650366
        8225.8555204729496786 254.47180588349484263 -46043118.073300328855 -8095.7671855398170966
        -460.27902111769228197 -14.211718368419901672 2567674.4468897907113 82973527.184557822532
        4708358.8531394982719 145655.37312989676351 -26354024397.534134807 0.000061691027340734916197
        -0.87326186130923084319 -0.73819034125209964056 -0.041828910782535662474
        -0.0012958380442529991736 233.58160308256756248""",
}


@pytest.mark.parametrize(("motion", "time"), REFERENCE)
def test_elements_of_the_matrix(motion, time):
    expected = np.zeros((6, 6))
    for place, text in zip(ELEMENTS.split(), REFERENCE[motion, time].split(), strict=True):
        expected[int(place[0]) - 1, int(place[1]) - 1] = float(text)
    # Worst elements: those where hyperbolic and trigonometric parts nearly cancel lose two digits in (22).
    for matrix, tolerance in (
        (equator_formulas.transition_matrix([time], *motion)[0], 3e-14),
        (equator_robust.transition_matrix([time], *motion)[0], 4e-15),
    ):
        np.testing.assert_allclose(matrix, expected, rtol=tolerance, atol=0)


def test_literal_formulas_under_misalignment_near_a_resonance():
    # 1 m/s from 2 omega_N = mu the particular solution loses three digits; the robust form does not.
    motion = (SINGULAR["2 omega_N = mu"] + 1, 0.0)
    literal = end_state(equator_formulas.corrected, motion, misaligned=True)
    robust = end_state(equator_robust.robust, motion, misaligned=True)
    assert 1e-13 < state_error(literal, motion, 7200.0, misaligned=True) < 1.5e-12
    assert state_error(robust, motion, 7200.0, misaligned=True) < 3e-13


@pytest.mark.parametrize("subject", [equator_formulas.printed, equator_formulas.amplitude_phase_printed])
def test_printed_editions_have_no_response_to_misalignment(subject):
    with pytest.raises(NotApplicableError, match="prints no response"):
        subject([1.0], *FIGHTER, INITIAL, GENERAL)


def test_unknown_edition():
    with pytest.raises(ValueError, match="edition"):
        equator_formulas.transition_matrix([0.0], *FIGHTER, edition="revised")


@pytest.mark.parametrize("misalignment", [None, GENERAL])
def test_compact_formulas_refuse_exact_resonance(misalignment):
    # Where omega_N equals the Schuler rate in float64, only the misalignment resonates.
    radius = 6378245.0
    speed = radius * (np.sqrt(9.78049 / radius) - EARTH_RATE)
    candidates = speed + np.arange(-40, 41) * np.spacing(speed)
    motions = [EquatorMotion.at(v, 0.0) for v in candidates]
    exact = [m.v_east for m in motions if m.inertial_rate**2 == m.schuler_rate**2]
    assert exact
    assert np.isfinite(equator_robust.robust([3600.0], exact[0], 0.0, INITIAL, misalignment)).all()
    if misalignment is None:
        assert np.isfinite(equator_formulas.corrected([3600.0], exact[0], 0.0, INITIAL)).all()
    else:
        with pytest.raises(NotApplicableError, match="resonance"):
            equator_formulas.corrected([3600.0], exact[0], 0.0, INITIAL, misalignment)
