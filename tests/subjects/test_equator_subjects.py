"""The equator subjects against an independent solution in 50 digits."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import MPContext

from sinsbench.subjects import equator_formulas, equator_numerical, equator_robust
from sinsbench.subjects.equator_model import (
    EARTH_RADIUS,
    EARTH_RATE,
    EquatorMotion,
    NotApplicableError,
    forcing,
    particular_solution,
)

context = MPContext()
context.dps = 50
mpf = context.mpf

EPS = float(np.finfo(np.float64).eps)
INITIAL = (0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7)  # the initial errors (24) of the paper
FIGHTER, SHIP = (600.0, 10000.0), (10.0, 0.0)  # the two motions of the paper: v_E in m/s, H in m
STATIONARY = -EARTH_RATE * EARTH_RADIUS  # omega_N = 0
V_MAX = 7446.951262516  # a_H = 0 eastward
GENERAL = np.array([[3.0, -1.0, 2.0], [0.5, -2.0, 1.5], [-2.5, 4.0, 1.0]]) * 1e-4  # a misalignment, rad
LONGITUDE = 0.7  # inertial longitude at t = 0, rad

SINGULAR = {  # speeds at H = 0 where a formula, or the motion itself, degenerates
    "at rest": 0.0,
    "omega_N = 0": STATIONARY,
    "1 mm/s from omega_N = 0": STATIONARY + 1e-3,
    "1 m/s from omega_N = 0": STATIONARY + 1,
    "2u + v/R = 0": 2 * STATIONARY,
    "1 m/s below a_H = 0": V_MAX - 1,
    "1 um/s below a_H = 0": V_MAX - 1e-6,
    "a_H = 0": V_MAX,
    "1 m/s beyond a_H = 0": V_MAX + 1,
    "negative rho": 7700.0,
    "rho_1 = rho_2": 7941.571244,
    "just beyond rho_1 = rho_2": 7941.6,
    "complex rho": 8000.0,
    "fast complex rho": 12000.0,
    "a_H = 0 westward": -8376.9,
    "beyond a_H = 0 westward": -8380.0,
    "complex rho westward": -9000.0,
    "omega = omega_N": 7433.276470,
    "omega = -omega_N": -8363.224591,
    "2 omega_N = mu": 3644.262041,
    "2 omega_N = -mu": -4574.210162,
}
MOTIONS = {"fighter": FIGHTER, "ship": SHIP} | {name: (speed, 0.0) for name, speed in SINGULAR.items()}
every_motion = pytest.mark.parametrize("name", MOTIONS)


def generator(v_east, height, misalignment):
    """The equations (8)-(9) for the state and 1, cos th, sin th, cos 2th, sin 2th, in 50 digits."""
    v, R, u = mpf(v_east), mpf(6378245) + mpf(height), mpf("7.29e-5")
    g = mpf("9.78049") * mpf(6378245) ** 2 / R**2
    rate, a_H = u + v / R, g - 2 * u * v - v**2 / R
    A = context.zeros(11)
    A[0, 4] = -g
    A[1, 2], A[1, 3] = 2 * rate, 2 * g / R - (v / R) ** 2
    A[2, 1], A[2, 5] = -(2 * u + v / R), -a_H
    A[3, 1] = 1
    A[4, 0] = 1 / R
    A[5, 2], A[5, 3] = 1 / R, -v / R**2
    (_, l12, l13), (_, l22, l23), (_, l32, l33) = [[mpf(float(x)) for x in row] for row in misalignment]
    A[0, 7], A[0, 8] = a_H * l12, a_H * l13
    # cos^2 = (1 + cos 2th)/2, sin^2 = (1 - cos 2th)/2, cos sin = (sin 2th)/2
    A[1, 6], A[1, 9], A[1, 10] = a_H * (l22 + l33) / 2, a_H * (l22 - l33) / 2, a_H * (l32 + l23) / 2
    A[2, 6], A[2, 9], A[2, 10] = a_H * (l32 - l23) / 2, a_H * (l32 + l23) / 2, a_H * (l33 - l22) / 2
    A[7, 8], A[8, 7], A[9, 10], A[10, 9] = -rate, rate, -2 * rate, 2 * rate
    return A


@cache
def exact_exponential(v_east, height, time, misaligned):
    return context.expm(generator(v_east, height, GENERAL if misaligned else np.zeros((3, 3))) * mpf(time))


def scales(v_east, height):
    R = 6378245.0 + height
    speed = 6378245.0 * np.sqrt(9.78049 / R)
    return np.array([speed, speed, speed, R, 1.0, 1.0])


def as_floats(matrix):
    return np.array([[float(matrix[i, j]) for j in range(6)] for i in range(6)])


def matrix_error(matrix, motion, time):
    """Error of P(t) in natural units (velocities by sqrt(gR), heights by R), relative to P(t)."""
    exact = exact_exponential(*motion, time, False)
    error = np.array([[float(mpf(float(matrix[i, j])) - exact[i, j]) for j in range(6)] for i in range(6)])
    scale = scales(*motion)
    weight = scale / scale[:, None]
    return np.linalg.norm(error * weight) / np.linalg.norm(as_floats(exact) * weight)


def exact_state(motion, time, initial=INITIAL, misaligned=False):
    th = mpf(LONGITUDE)
    ring = [mpf(1), context.cos(th), context.sin(th), context.cos(2 * th), context.sin(2 * th)]
    return (exact_exponential(*motion, time, misaligned) * context.matrix([*map(mpf, initial), *ring]))[:6]


def state_error(state, motion, time, initial=INITIAL, misaligned=False):
    """Error of the state in natural units, relative to the state.

    The forcing is a_H Lambda, and a_H = g - 2uv - v^2/R carries the rounding of g however small it is.
    Under a misalignment the response to a forcing g Lambda is thus added to the size it is compared with.
    """
    exact, scale = exact_state(motion, time, initial, misaligned), scales(*motion)
    error = np.array([float(mpf(float(value)) - truth) for value, truth in zip(state, exact, strict=True)])
    size = np.linalg.norm(np.array([float(x) for x in exact]) / scale)
    if misaligned:
        response = exact - exact_state(motion, time, initial)
        ratio = abs(mpf("9.78049") / generator(*motion, GENERAL)[2, 5])
        size += np.linalg.norm(np.array([float(x * ratio) for x in response]) / scale)
    return np.linalg.norm(error / scale) / size


def end_state(subject, motion, time=7200.0, misaligned=False):
    lead = {"misalignment": GENERAL, "inertial_longitude": LONGITUDE} if misaligned else {}
    return subject([time], *motion, INITIAL, **lead)[-1]


# The robust form


@every_motion
def test_robust_matrix_is_accurate_at_every_speed(name):
    # 30 eps after 7200 s: the rounding of rho enters the exponent, beta3 t = 12.5, and cosh and cos of it.
    for time, tolerance in ((1.0, 2 * EPS), (3600.0, 30 * EPS), (7200.0, 30 * EPS)):
        matrix = equator_robust.transition_matrix([time], *MOTIONS[name])[0]
        assert matrix_error(matrix, MOTIONS[name], time) < tolerance


@pytest.mark.parametrize("motion", [FIGHTER, SHIP])
def test_robust_matrix_after_a_day(motion):
    # The exponent is 150 by then; 1e-15 and 9e-15 are the known errors.
    assert matrix_error(equator_robust.transition_matrix([86400.0], *motion)[0], motion, 86400.0) < 2e-14


def test_robust_keeps_every_element_at_early_instants():
    # Elements of P(1 s) are as small as t^3: no difference may cancel.  The worst measured is 1.6 eps.
    for motion in (FIGHTER, SHIP):
        matrix = equator_robust.transition_matrix([1.0], *motion)[0]
        exact = as_floats(exact_exponential(*motion, 1.0, False))
        np.testing.assert_allclose(matrix, exact, rtol=4 * EPS, atol=0)


@every_motion
def test_robust_under_misalignment(name):
    # Near 2 omega_N = +-mu the answer comes from the exponential, which is good to 3e-13.
    tolerance = 3e-13 if name.startswith("2 omega_N") else 3e-14
    for time in (1.0, 7200.0):
        state = end_state(equator_robust.robust, MOTIONS[name], time, misaligned=True)
        assert state_error(state, MOTIONS[name], time, misaligned=True) < tolerance


@settings(deadline=None, max_examples=60)
@given(
    v_east=st.floats(-12000, 12000),
    height=st.floats(-5000, 1e6),
    first=st.floats(0, 4000),
    second=st.floats(0, 4000),
)
def test_robust_semigroup(v_east, height, first, second):
    matrices = equator_robust.transition_matrix(sorted([first, second]), v_east, height)
    whole = equator_robust.transition_matrix([first + second], v_east, height)[0]
    scale = scales(v_east, height)
    weight = scale / scale[:, None]
    left, right = matrices * weight
    # Factors of norm up to 4e4 may cancel: the tolerance, the error of either factor, scales with both.
    bound = 200 * EPS * np.linalg.norm(left) * np.linalg.norm(right)
    assert np.linalg.norm(left @ right - whole * weight) < bound


# The formulas of the paper


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


# Misalignment


@settings(max_examples=30)
@given(
    misalignment=st.lists(st.floats(-1e-2, 1e-2), min_size=9, max_size=9),
    angle=st.floats(-10, 10),
    v_east=st.floats(-9000, 9000),
)
def test_forcing_is_the_printed_one(misalignment, angle, v_east):
    (_, l12, l13), (_, l22, l23), (_, l32, l33) = matrix = np.reshape(misalignment, (3, 3))
    motion, c, s = EquatorMotion.at(v_east, 0.0), np.cos(angle), np.sin(angle)
    north = l12 * c + l13 * s
    up = l22 * c**2 + (l32 + l23) * c * s + l33 * s**2
    east = l32 * c**2 + (l33 - l22) * c * s - l23 * s**2
    expected = motion.specific_force * np.array([north, up, east, 0, 0, 0])
    # A few roundings of terms no larger than 3 max|Lambda| a_H; half an ulp of 20 rad in the double angle.
    bound = 16 * EPS * abs(motion.specific_force) * np.abs(matrix).max() * 3
    np.testing.assert_allclose(forcing(motion, matrix, angle), expected, atol=bound)


def test_small_rotation_about_north_is_an_offset_of_longitude():
    offset = 1e-5
    rotation = np.zeros((3, 3))
    rotation[2, 1], rotation[1, 2] = offset, -offset
    time = np.array([60.0, 3600.0, 7200.0])
    shifted = equator_robust.robust(time, *FIGHTER, np.array(INITIAL) - offset * np.eye(6)[5])
    expected = shifted + offset * np.eye(6)[5]
    actual = equator_robust.robust(time, *FIGHTER, INITIAL, rotation, LONGITUDE)
    # Cancellation with the offset itself: eps of its response.
    np.testing.assert_allclose(actual / scales(*FIGHTER), expected / scales(*FIGHTER), rtol=1e-12, atol=1e-20)


def test_literal_formulas_under_misalignment_near_a_resonance():
    # 1 m/s from 2 omega_N = mu the particular solution loses three digits; the robust form does not.
    motion = (SINGULAR["2 omega_N = mu"] + 1, 0.0)
    literal = end_state(equator_formulas.corrected, motion, misaligned=True)
    robust = end_state(equator_robust.robust, motion, misaligned=True)
    assert 1e-13 < state_error(literal, motion, 7200.0, misaligned=True) < 1.5e-12
    assert state_error(robust, motion, 7200.0, misaligned=True) < 3e-13


@pytest.mark.parametrize(("v_east", "height"), [(3644.262041013479, 0.0), (-3871.1515824743283, 46723971.494846754)])
def test_particular_solution_refuses_to_divide_by_zero(v_east, height):
    # Places, found by search, where 2 omega_N = mu or a_24 + 2 omega_N v/R = 0 holds exactly in float64.
    with pytest.raises(NotApplicableError, match="divides by zero"):
        particular_solution(EquatorMotion.at(v_east, height), GENERAL, 0.0)
    assert np.isfinite(equator_robust.robust([7200.0], v_east, height, INITIAL, GENERAL)).all()


@pytest.mark.parametrize("subject", [equator_formulas.printed, equator_formulas.amplitude_phase_printed])
def test_printed_editions_have_no_response_to_misalignment(subject):
    with pytest.raises(NotApplicableError, match="prints no response"):
        subject([1.0], *FIGHTER, INITIAL, GENERAL)


# Numerical subjects: bounds are a few times the errors measured; DOP853 is limited by rounding, the others
# by the smallest tolerance SciPy accepts, the exponential by its squarings.
NUMERICAL = {
    equator_numerical.expm: 6e-13,
    equator_numerical.rk45: 3e-13,
    equator_numerical.dop853: 3e-13,
    equator_numerical.lsoda: 3e-12,
    equator_numerical.radau: 1e-13,
}


@pytest.mark.parametrize("subject", NUMERICAL, ids=lambda subject: subject.__name__)
def test_numerical_subjects(subject):
    for motion, misaligned in ((FIGHTER, False), (FIGHTER, True), (SHIP, False)):
        if subject is equator_numerical.radau and (motion is SHIP or misaligned):
            continue  # 10,000 implicit steps a run
        state = end_state(subject, motion, misaligned=misaligned)
        assert state_error(state, motion, 7200.0, misaligned=misaligned) < NUMERICAL[subject]


@every_motion
def test_exponential_at_every_speed(name):
    for misaligned in (False, True):
        state = end_state(equator_numerical.expm, MOTIONS[name], misaligned=misaligned)
        assert state_error(state, MOTIONS[name], 7200.0, misaligned=misaligned) < 6e-13


@pytest.mark.parametrize("subject", [equator_numerical.rk45, equator_numerical.dop853])
def test_integrators_beyond_the_stability_limit(subject):
    motion = (8000.0, 0.0)
    assert state_error(end_state(subject, motion, misaligned=True), motion, 7200.0, misaligned=True) < 3e-13


# The contract

EVERY_SUBJECT = [*REGULAR_SUBJECTS, equator_formulas.printed, equator_formulas.amplitude_phase_printed]
EVERY_SUBJECT += [subject for subject in NUMERICAL if subject is not equator_numerical.radau]


@pytest.mark.parametrize("subject", EVERY_SUBJECT, ids=lambda subject: subject.__name__)
def test_any_ascending_instants(subject):
    time = np.array([0.0, 0.0, 100.0, 250.0])
    errors = subject(time, *FIGHTER, INITIAL)
    assert errors.shape == (4, 6)
    assert errors.dtype == np.float64
    np.testing.assert_array_equal(errors[0], errors[1])
    late = subject(time[2:], *FIGHTER, INITIAL)
    # The interpolated instants of an integrator do not depend on what else is asked for.
    np.testing.assert_allclose(late, errors[2:], rtol=1e-12)
    assert subject([], *FIGHTER, INITIAL).shape == (0, 6)
    assert subject([0.0], *FIGHTER, INITIAL).shape == (1, 6)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"time": [2.0, 1.0]}, "ascending"),
        ({"time": [-1.0]}, "negative"),
        ({"time": [np.nan]}, "finite"),
        ({"time": 1.0}, "shape"),
        ({"v_east": np.inf}, "v_east"),
        ({"height": -6378245.0}, "height"),
        ({"height": np.nan}, "height"),
        ({"initial_errors": [0.0]}, "initial_errors"),
        ({"initial_errors": [np.nan] * 6}, "initial_errors"),
        ({"misalignment": np.zeros((3, 2))}, "misalignment"),
        ({"inertial_longitude": np.nan}, "inertial_longitude"),
    ],
)
def test_bad_arguments(changes, sentence):
    arguments = {"time": [1.0], "v_east": 600.0, "height": 0.0, "initial_errors": INITIAL} | changes
    with pytest.raises(ValueError, match=sentence):
        equator_robust.robust(**arguments)


@pytest.mark.parametrize("subject", [equator_formulas.corrected, equator_robust.robust, equator_numerical.expm])
def test_overflow_is_reported(subject):
    with pytest.raises(NotApplicableError, match="range of float64"):
        subject([5e5], *FIGHTER, INITIAL)


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
