"""Errors along the equator: closed form against series, exponentials of matrices and the printed digits.

Differences are measured in the scaled norm: velocities in units of sqrt(g R), heights in units of R, angles in
radians; relative to the largest component of the solution.
"""

import pytest
from flint import arb, arb_mat
from hypothesis import given, settings
from hypothesis import strategies as st

from equator_truth import GRAVITY, A, U, constants, generator, leading_block
from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.equator import (
    COUPLED,
    EquatorModel,
    coupled_functions,
    guard_bits,
    homogeneous,
    series_functions,
    transition,
)
from sinsref.equator_forced import Misalignment, solution
from sinsref.exact import ExactNumber
from sinsref.taylor import integrate

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=25)
BITS = 320


def root_of(function, low, high):
    """Find a zero between two speeds at H = 0 to 70 digits."""
    ar = MpArithmetic(90)

    def at(v):
        return function(EquatorModel.at(ar, ExactNumber(ar.context.nstr(v, 85)), ExactNumber(0)), ar)

    low, high = ar.number(low), ar.number(high)
    rising = at(high) > at(low)
    assert (at(low) > 0) != (at(high) > 0)
    for _ in range(260):
        middle = (low + high) / 2
        low, high = (low, middle) if (at(middle) > 0) == rising else (middle, high)
    return ar.context.nstr(low, 75)


def discriminant(model, ar):
    return model.p**2 + 4 * model.q


def double_frame_rate_less_mu(model, ar):
    rho2 = -(model.p + ar.sqrt(discriminant(model, ar))) / 2
    return 4 * model.frame_rate**2 + rho2


#: Every speed at which some closed form of the paper divides by zero, and what lies beyond: v at H = 0.
SPEEDS = {
    "fighter": "600",
    "ship": "10",
    "rest": "0",
    "frame rate zero": f"-{U}*{A}",
    "Coriolis rate zero": f"-2*{U}*{A}",
    "v_max exactly": f"{A}*(sqrt({U}*{U} + {GRAVITY}/{A}) - {U})",
    "v_max less 1 mm/s": "7446.950262516",
    "v_max and 1 m/s": "7447.951262516",
    "v_min exactly": f"-{A}*(sqrt({U}*{U} + {GRAVITY}/{A}) + {U})",
    "resonance east exactly": f"{A}*(sqrt({GRAVITY}/{A}) - {U})",
    "resonance east printed": "7433.276470",
    "resonance west exactly": f"-{A}*(sqrt({GRAVITY}/{A}) + {U})",
    "resonance west printed": "-8363.224591",
    "2 omega_N = mu to 70 digits": root_of(double_frame_rate_less_mu, 3644, 3645),
    "2 omega_N = mu printed": "3644.262041",
    "2 omega_N = -mu to 70 digits": root_of(double_frame_rate_less_mu, -4575, -4574),
    "2 omega_N = -mu printed": "-4574.210162",
    "double root to 70 digits": root_of(discriminant, 7941, 7942),
    "double root printed": "7941.571244",
    "two oscillations": "7700",
    "complex roots": "8000",
    "far beyond": "12000",
    "beyond v_min": "-8380",
    "far beyond v_min": "-9000",
}


def matrix(v_east, height):
    """The matrix A of (10), written out."""
    return leading_block(generator(v_east, height))


def forced_field(ar, v_east, height, tilt, longitude):
    """X' = A X + b(t) with b of (8), written out."""
    _, _, _, turn, _, force, _ = constants(v_east, height)
    rows = matrix(v_east, height)

    def field(series, t, x):
        sine, cosine = series.sin_cos(t * turn + longitude)
        (_, l12, l13), (_, l22, l23), (_, l32, l33) = tilt
        b = [
            (cosine * l12 + sine * l13) * force,
            (cosine * cosine * l22 + cosine * sine * (l32 + l23) + sine * sine * l33) * force,
            (cosine * cosine * l32 + cosine * sine * (l33 - l22) - sine * sine * l23) * force,
        ]
        rates = [sum((x[j] * a for j, a in enumerate(row) if not a.is_zero()), series.number(0)) for row in rows]
        return [r + f for r, f in zip(rates, b, strict=False)] + rates[3:]

    return field


def scaled(ar, v_east, height, state):
    _, R, g, *_ = constants(v_east, height)
    speed = ar.sqrt(g * R)
    return [x / s for x, s in zip(state, (speed, speed, speed, R, ar.number(1), ar.number(1)), strict=True)]


def difference(ar, v_east, height, found, expected):
    found, expected = (scaled(ar, v_east, height, x) for x in (found, expected))
    return max(ar.magnitude(x - y) for x, y in zip(found, expected, strict=True)) / max(map(ar.magnitude, expected))


INITIAL = ("0.01", "-0.02", "0.03", "1", "1e-7", "-2e-7")
TILT = (("1e-6", "-2e-6", "3e-6"), ("5e-6", "4e-6", "-7e-6"), ("2e-6", "6e-6", "-1e-6"))
LONGITUDE = "0.3"


def check_against_the_differential_equation(v_east, height, initial, tilt, longitude, time):
    with BallArithmetic(BITS) as ar:
        elements = [[ar.number(x) for x in row] for row in tilt]
        start = [ar.number(x) for x in initial]
        model = EquatorModel.at(ar, ExactNumber(v_east), ExactNumber(height))
        misalignment = Misalignment(elements, ar.number(longitude))
        found = solution(ar, model, start, misalignment, ar.number(time))
        field = forced_field(ar, v_east, height, elements, ar.number(longitude))
        # All rates are below 1/200 s, so that a step of 300 s reaches 1.5^50/50! = 2e-56.
        reached = integrate(
            ar, field, start, ar.number(0), ar.number(time), steps=int(float(time) // 300) + 1, order=50
        )
        assert difference(ar, v_east, height, found, reached) < 1e-40
        assert max(float(x.rad()) for x in scaled(ar, v_east, height, found)) < 1e-45


@pytest.mark.parametrize("v_east", SPEEDS.values(), ids=SPEEDS)
def test_the_solution_holds_at_every_degenerate_speed(v_east):
    check_against_the_differential_equation(v_east, "0", INITIAL, TILT, LONGITUDE, "1800")


errors = st.tuples(*[st.floats(-1, 1)] * 3, st.floats(-100, 100), *[st.floats(-1e-5, 1e-5)] * 2)
elements = st.floats(-1e-4, 1e-4)
tilts = st.tuples(*[st.tuples(*[elements] * 3)] * 3)


@settings(deterministic, max_examples=15)
@given(
    st.floats(-9500, 12500), st.floats(-1e4, 1e6), errors, tilts, st.floats(-4, 4), st.floats(1, 3600)
)  # fmt: skip
def test_the_solution_holds_at_random(v_east, height, initial, tilt, longitude, time):
    if not any(initial):
        initial = INITIAL
    check_against_the_differential_equation(v_east, height, initial, tilt, longitude, time)


@pytest.mark.parametrize("v_east", ["600", f"-{U}*{A}", "8000"])
def test_a_misalignment_alone_moves_every_component(v_east):
    """Nothing of the force is hidden behind the initial errors: each element by itself."""
    zero, time = ("0",) * 6, "900"
    for i, j in ((0, 1), (0, 2), (1, 1), (1, 2), (2, 1), (2, 2)):
        tilt = [["1e-6" if (m, n) == (i, j) else "0" for n in range(3)] for m in range(3)]
        check_against_the_differential_equation(v_east, "10000", zero, tilt, LONGITUDE, time)


def test_without_misalignment_the_solution_is_the_homogeneous_one():
    with BallArithmetic(BITS) as ar:
        model = EquatorModel.at(ar, ExactNumber("600"), ExactNumber("10000"))
        start = [ar.number(x) for x in INITIAL]
        zero = Misalignment([[ar.number(0)] * 3] * 3, ar.number(LONGITUDE))
        t = ar.number(3600)
        plain = homogeneous(ar, model, start, t)
        assert all(x.mid() == y.mid() for x, y in zip(solution(ar, model, start, None, t), plain, strict=True))
        assert all(x.overlaps(y) for x, y in zip(solution(ar, model, start, zero, t), plain, strict=True))
        assert max(map(ar.magnitude, zero.force(ar, model, t))) == 0


@pytest.mark.parametrize("v_east", SPEEDS.values(), ids=SPEEDS)
@pytest.mark.parametrize("time", ["1", "7200"])
def test_the_transition_matrix_is_the_exponential(v_east, time):
    with BallArithmetic(BITS) as ar:
        t = ar.number(time)
        model = EquatorModel.at(ar, ExactNumber(v_east), ExactNumber("0"))
        found = transition(ar, model, t)
        expected = (arb_mat(matrix(v_east, "0")) * t).exp()
        homogeneous_state = homogeneous(ar, model, [ar.number(x) for x in INITIAL], t)
        for i in range(6):
            assert homogeneous_state[i].overlaps(sum(found[i][j] * ar.number(x) for j, x in enumerate(INITIAL)))
            for j in range(6):
                assert found[i][j].overlaps(expected[i, j])
                # Relative to the largest element, in scaled units these are of one size.
                assert ar.magnitude(found[i][j] - expected[i, j]) < 1e-45 * (1e12 if time == "7200" else 1e8)
        own = arb_mat(model.matrix(ar)) - arb_mat(matrix(v_east, "0"))
        assert all(x.contains(0) and x.rad() < 1e-80 for x in own.entries())


@deterministic
@given(st.floats(-9500, 12500), st.floats(-1e4, 1e6), st.floats(-3600, 3600), st.floats(-3600, 3600))
def test_the_transition_matrix_is_a_group(v_east, height, s, t):
    with BallArithmetic(BITS) as ar:
        model = EquatorModel.at(ar, ExactNumber(v_east), ExactNumber(height))
        of_s, of_t, of_both, of_zero = (arb_mat(transition(ar, model, arb(x))) for x in (s, t, arb(s) + t, 0))
        residual = of_s * of_t - of_both
        assert all(x.contains(0) for x in residual.entries())
        _, R, g, *_ = constants(v_east, height)
        units = [ar.sqrt(g * R)] * 3 + [R, arb(1), arb(1)]
        size = max(ar.magnitude(of_s[i, j] * of_t[j, i]) for i in range(6) for j in range(6)) + 1
        assert all(
            ar.magnitude(residual[i, j] * units[j] / units[i]) < 1e-60 * size for i in range(6) for j in range(6)
        )
        assert all((x - int(n % 7 == 0)).contains(0) for n, x in enumerate(of_zero.entries()))
        assert all(x.rad() < 1e-60 for x in of_zero.entries())


rates = st.floats(-4e-6, 4e-6)


@deterministic
@given(rates, st.floats(-4e-12, 4e-12), st.floats(1, 5000))
def test_the_three_branches_agree_with_the_series(p, q, time):
    with BallArithmetic(BITS) as ar:
        closed, series = (f(ar, arb(p), arb(q), arb(time)) for f in (coupled_functions, series_functions))
        for k, (x, y) in enumerate(zip(closed, series, strict=True)):
            assert x.overlaps(y)
            # c_k grows as t^k/k!.
            assert ar.magnitude(x - y) < 1e-60 * (1 + time**k)


@pytest.mark.parametrize("q", [2e-12, 1e-15, 0.0, -1e-15, -1e-12, -4e-12])
@pytest.mark.parametrize("p", [2e-6, 1e-9, 0.0, -1e-9, -2e-6])
@pytest.mark.parametrize("time", [1.0, 4000.0])
def test_the_functions_make_the_exponential_of_a_companion_matrix(p, q, time):
    """The roots real of either sign, complex, double, zero: for A^4 + p A^2 - q = 0 exp(A t) is the sum of c_k A^k."""
    with BallArithmetic(BITS) as ar:
        p, q, t = arb(p), arb(q), arb(time)
        companion = arb_mat([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [q, 0, -p, 0]])
        expected = (companion * t).exp()
        # The first row of A^k is the k-th unit vector.
        for values in (coupled_functions(ar, p, q, t), series_functions(ar, p, q, t)):
            for k, x in enumerate(values):
                assert x.overlaps(expected[0, k])
                assert x.rad() < 1e-60 * (1 + time**k)


@pytest.mark.parametrize("v_east", SPEEDS.values(), ids=SPEEDS)
def test_balls_enclose_at_low_precision(v_east):
    """Two hours at 160 bits; the higher precision lies inside, and `guard_bits` covers what cancels."""

    def state(ar):
        model = EquatorModel.at(ar, ExactNumber(v_east), ExactNumber("0"))
        tilt = Misalignment([[ar.number(x) for x in row] for row in TILT], ar.number(LONGITUDE))
        return solution(ar, model, [ar.number(x) for x in INITIAL], tilt, ar.number(7200))

    with BallArithmetic(160) as coarse:
        low = state(coarse)
        guard = guard_bits(coarse, EquatorModel.at(coarse, ExactNumber(v_east), ExactNumber("0")), coarse.number(7200))
    with BallArithmetic(500) as fine:
        high = state(fine)
        assert all(x.overlaps(y) for x, y in zip(low, high, strict=True))
        assert guard < 160
        size = max(map(fine.magnitude, scaled(fine, v_east, "0", high)))
        for x in scaled(fine, v_east, "0", low):
            assert float(x.rad()) < 2.0 ** (guard + 20 - 160) * (1 + size)


def test_the_readable_arithmetic_agrees_with_the_balls():
    readable = MpArithmetic(60)

    def state(ar):
        model = EquatorModel.at(ar, ExactNumber("600"), ExactNumber("10000"))
        tilt = Misalignment([[ar.number(x) for x in row] for row in TILT], ar.number(LONGITUDE))
        return solution(ar, model, [ar.number(x) for x in INITIAL], tilt, ar.number(3600))

    with BallArithmetic(BITS) as ar:
        digits = [arb(readable.context.nstr(x, 60)) for x in state(readable)]
        for x, y in zip(*(scaled(ar, "600", "10000", found) for found in (state(ar), digits)), strict=True):
            assert abs(x - y) < 1e-45


#: Elements of P(t) to 20 digits, v and H in the key; the constants of section 4 to 15 or more.
REFERENCE = {
    ("600", "10000", "3600"): """
        p11 -0.26184459752558476752  p15 7616.7124422787727074  p22 253.37050922065341051
        p23 32.421109564274824544  p24 0.44669148334069512951  p26 -180447.7038959804277
        p32 -18.684236171965733196  p33 -2.6521600680940432568  p34 -0.033127561476988772257
        p36 20937.439193150304879  p42 146257.52127341931876  p43 18784.777562837089059
        p44 257.87364323341469007  p46 -104620185.01602282409  p51 -0.00012228864011938417251
        p55 -0.26184459752558476752  p62 -0.0029405224068327199504  p63 -0.00050131500632600641
        p64 -5.1952964285984060539e-6  p66 1.8509739446672362983
    """,
    ("600", "10000", "7200"): """
        p11 -0.86287481349332905489  p15 -3988.7900078331980789  p22 129453.45091860172252
        p23 16610.028363238071336  p24 228.23185582032102884  p26 -92108261.244217467241
        p32 -9591.2028847581316824  p33 -1231.5198410353047751  p34 -16.909730747614829441
        p36 6820564.3413920305673  p42 74729961.28128680349  p43 9588557.5810358382681
        p44 131752.04400185999396  p46 -53170966255.713902692  p51 0.000064041239508022454054
        p55 -0.86287481349332905489  p62 -1.5009689799054103698  p63 -0.19252584028581770413
        p64 -0.0026462453480576341324  p66 1067.0732422229666663
    """,
    ("10", "0", "3600"): """
        p11 -0.25173213808607072331  p15 7643.9027500372233988  p22 269.00558179034403656
        p23 15.225573836589235988  p24 0.47221782701687635164  p26 -85518.597604423327573
        p32 -14.984171757951686137  p33 -1.0948847483796882749  p34 -0.026396262357415466374
        p36 12441.065539680638826  p42 153972.16010595591522  p43 8745.112472570629183
        p44 270.29433003324258105  p46 -49153123.983607871079  p51 -0.00012253307783776478893
        p55 -0.25173213808607072331  p62 -0.0013710844397746761347  p63 -0.00020069800854708024318
        p64 -2.4166866516747954967e-6  p66 0.19386349451885622131
    """,
    ("10", "0", "7200"): """
        p11 -0.87326186130923084319  p15 -3848.4319651777321288  p22 144961.51250569650366
        p23 8225.8555204729496786  p24 254.47180588349484263  p26 -46043118.073300328855
        p32 -8095.7671855398170966  p33 -460.27902111769228197  p34 -14.211718368419901672
        p36 2567674.4468897907113  p42 82973527.184557822532  p43 4708358.8531394982719
        p44 145655.37312989676351  p46 -26354024397.534134807  p51 0.000061691027340734916197
        p55 -0.87326186130923084319  p62 -0.73819034125209964056  p63 -0.041828910782535662474
        p64 -0.0012958380442529991736  p66 233.58160308256756248
    """,
}


@pytest.mark.parametrize(("case", "table"), REFERENCE.items(), ids=["-".join(case) for case in REFERENCE])
def test_reference_values_of_the_transition_matrix(case, table):
    v_east, height, time = case
    with BallArithmetic(BITS) as ar:
        found = transition(ar, EquatorModel.at(ar, ExactNumber(v_east), ExactNumber(height)), ar.number(time))
        words = table.split()
        printed = dict(zip(words[::2], words[1::2], strict=True))
        assert len(printed) == 20
        for name, digits in printed.items():
            x = found[int(name[1]) - 1][int(name[2]) - 1]
            last = arb(10) ** -len(digits.partition(".")[2].partition("e")[0])
            last = last * arb(10) ** int(digits.partition("e")[2] or 0)
            # Twenty digits rounded to nearest.
            assert abs(x - arb(digits)) < last * 0.501, name
        others = [found[i][j] for i in range(6) for j in range(6) if f"p{i + 1}{j + 1}" not in printed]
        assert len(others) == 16
        assert all(x.is_zero() for x in others)
        assert COUPLED == (1, 2, 3, 5)
