"""Regular precession and its dual analogue: the printed formulas, the equations of motion, quadrature."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.dual_quaternion import apparent_velocity
from sinsref.exact import ExactNumber
from sinsref.precession import (
    DualPrecession,
    angular_rate_and_specific_force,
    body_rate,
    frame_offset,
    increments,
    particular_solution,
    precession_attitude,
    solution,
)
from sinsref.quaternion import cross, dot, product, rotate
from sinsref.series import SeriesArithmetic
from sinsref.taylor import integrate

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=40)
few = settings(derandomize=True, deadline=None, database=None, max_examples=8)
AR = MpArithmetic(60)
ratios = st.one_of(st.sampled_from([0.0, 1.0, -1.0, 0.5, 1e-12, -1e-3]), st.floats(-2, 2))
nutations = st.one_of(st.sampled_from(["0", "pi", "pi/2", "pi/18", "1e-20", "pi - 1e-15"]), st.floats(1e-6, 3.1))
velocities = st.floats(-100, 100)


@st.composite
def motions(draw):
    attitude = None
    if draw(st.booleans()):
        attitude = tuple(ExactNumber(draw(st.floats(low, 1))) for low in (0.1, -1, -1, -1))
    return DualPrecession(
        ExactNumber(draw(st.floats(0.1, 7)) * draw(st.sampled_from([1, -1]))),
        ExactNumber(draw(ratios)),
        ExactNumber(draw(nutations)),
        ExactNumber(draw(velocities)),
        ExactNumber(draw(velocities)),
        attitude,
        tuple(ExactNumber(draw(velocities)) for _ in range(3)),
    )


def paper_motion(**changed):
    values = {
        "spin_rate": "2*pi", "precession_ratio": "1/2", "nutation": "pi/18", "spin_rate_dual": "10",
        "nutation_dual": "100", "initial_attitude": ("1", "0", "0", "0"), "initial_velocity": ("20", "35", "40"),
    } | changed  # fmt: skip
    exact = {k: tuple(map(ExactNumber, v)) if isinstance(v, tuple) else v and ExactNumber(v) for k, v in values.items()}
    return DualPrecession(**exact)


def near(a, b, tolerance="1e-45"):
    """Within the tolerance of the largest component, and of 1."""
    scale = max([1, *(abs(x) for x in (*a, *b))])
    return all(abs(x - y) <= AR.number(tolerance) * scale for x, y in zip(a, b, strict=True))


def parameters(motion, ar=AR):
    return [*motion.principal(ar), ar.number(motion.spin_rate_dual), ar.number(motion.nutation_dual)]


# The formulas of the paper, written out.


def equation_4_1(nu, eps, th, t):
    (s, c), (sn, cn) = AR.sin_cos(th), AR.sin_cos(nu * t)
    return [eps * nu * s * sn, eps * nu * s * cn, nu * (1 + eps * c)]


def equation_4_3(nu, eps, th, nu0, th0, t):
    (s, c), (sn, cn) = AR.sin_cos(th), AR.sin_cos(nu * t)
    swing, drift = eps * (nu * th0 * c + nu0 * s), eps * nu * nu0 * t * s
    return [swing * sn + drift * cn, swing * cn - drift * sn, nu0 * (1 + eps * c) - eps * nu * th0 * s]


def equation_4_4(nu, eps, th, t):
    (s, c), (sp, cp) = AR.sin_cos(th / 2), AR.sin_cos((1 + eps) * nu * t / 2)
    sm, cm = AR.sin_cos((1 - eps) * nu * t / 2)
    return [c * cp, s * cm, -s * sm, c * sp]


def equation_4_5(nu, eps, th, nu0, th0, t):
    (s, c), (sp, cp) = AR.sin_cos(th / 2), AR.sin_cos((1 + eps) * nu * t / 2)
    sm, cm = AR.sin_cos((1 - eps) * nu * t / 2)
    return [
        -(1 + eps) / 2 * nu0 * t * c * sp - th0 / 2 * s * cp,
        -(1 - eps) / 2 * nu0 * t * s * sm + th0 / 2 * c * cm,
        -(1 - eps) / 2 * nu0 * t * s * cm - th0 / 2 * c * sm,
        (1 + eps) / 2 * nu0 * t * c * cp - th0 / 2 * s * sp,
    ]


def equation_4_6(nu, eps, th, nu0, th0, t):
    (s, c), (sn, cn) = AR.sin_cos(th), AR.sin_cos(nu * t)
    return [
        eps * nu0 * t * s * sn + th0 * cn,
        eps * nu0 * t * s * cn - th0 * sn,
        nu0 * t * (1 + eps * c),
    ]


def equation_4_7(nu, eps, th, nu0, th0, t):
    (s, c), (sn, cn) = AR.sin_cos(th), AR.sin_cos(eps * nu * t)
    return [nu0 * t * s * sn + th0 * cn, -nu0 * t * s * cn + th0 * sn, nu0 * t * (eps + c)]


def closing_formulas_of_section_4(nu, eps, th, nu0, th0, t0, t1):
    (s, c), (s0, c0), (s1, c1) = AR.sin_cos(th), AR.sin_cos(nu * t0), AR.sin_cos(nu * t1)
    h = t1 - t0
    p = [-eps * s * (c1 - c0), eps * s * (s1 - s0), nu * (1 + eps * c) * h]
    b = [
        eps * (nu0 * s * (t1 * s1 - t0 * s0) - th0 * c * (c1 - c0)),
        eps * (nu0 * s * (t1 * c1 - t0 * c0) + th0 * c * (s1 - s0)),
        (nu0 * (1 + eps * c) - eps * nu * th0 * s) * h,
    ]
    return p, b


times = st.floats(-50, 100).map(AR.number)


@deterministic
@given(motions(), times)
@example(paper_motion(), AR.number(100))
def test_the_transfer_principle_gives_the_printed_formulas(motion, t):
    given_parameters = parameters(motion)
    principal = given_parameters[:3]
    rate, force = angular_rate_and_specific_force(AR, motion, t)
    assert near(rate, equation_4_1(*principal, t))
    assert near(force, equation_4_3(*given_parameters, t))
    unit, dual = particular_solution(AR, motion, t)
    assert near(unit, equation_4_4(*principal, t))
    assert near(dual, equation_4_5(*given_parameters, t))
    inertial, body = apparent_velocity(unit, dual)
    assert near(body, equation_4_6(*given_parameters, t))
    assert near(inertial, equation_4_7(*given_parameters, t))


@deterministic
@given(motions(), times, st.floats(1e-3, 1))
@example(paper_motion(), AR.number(100), 0.01)
def test_increments_are_the_formulas_that_close_section_4(motion, t, h):
    h = AR.number(h)
    angle, velocity = increments(AR, motion, t, h)
    p, b = closing_formulas_of_section_4(*parameters(motion), t - h, t)
    assert near(angle, p)
    assert near(velocity, b)


@few
@given(motions(), st.floats(-20, 20), st.floats(0.01, 0.5))
def test_increments_are_the_integrals_of_rate_and_force(motion, t, h):
    start, h = AR.number(t), AR.number(h)
    angle, velocity = increments(AR, motion, start + h, h)
    for part, expected in enumerate((angle, velocity)):
        for i in range(3):
            integral = AR.context.quad(
                lambda tau, i=i, part=part: angular_rate_and_specific_force(AR, motion, tau)[part][i],
                [start, start + h],
            )
            assert abs(integral - expected[i]) < AR.number("1e-45") * (1 + abs(expected[i]))


@few
@given(motions(), st.floats(0.1, 0.6))
@example(paper_motion(), 0.3)
@example(paper_motion(precession_ratio="-1", initial_attitude=None), 0.3)
@example(paper_motion(precession_ratio="1"), 0.3)
@example(paper_motion(precession_ratio="0"), 0.3)
@example(paper_motion(nutation="1e-20"), 0.3)
@example(paper_motion(nutation="pi - 1e-15"), 0.3)
def test_the_solution_is_the_one_of_the_differential_equations(motion, end):
    """2 Lambda' = Lambda o omega, W_I' = a_I, W_E' = a - omega x W_E, with omega and a as printed: (4.1), (4.3)."""

    def field(ar, t, y):
        nu, eps, th, nu0, th0 = (ar.constant(x) for x in parameters(motion, ar.base))
        (s, c), (sn, cn) = ar.sin_cos(th), ar.sin_cos(nu * t)
        rate = [eps * nu * s * sn, eps * nu * s * cn, nu * (eps * c + 1)]
        swing, drift = eps * (nu * th0 * c + nu0 * s), eps * nu * nu0 * s * t
        force = [swing * sn + drift * cn, swing * cn - drift * sn, nu0 * (eps * c + 1) - eps * nu * th0 * s]
        return [
            *(x / 2 for x in product(y[:4], [ar.number(0), *rate])),
            *rotate(y[:4], force),
            *(x - z for x, z in zip(force, cross(rate, y[7:]), strict=True)),
        ]

    # Fewer than 1.5 rad a step (the rates of Lambda, of a and of W_E add up): 1.5^55 / 55! is 1e-63.
    steps = int(abs(float(motion.spin_rate)) * (2 + abs(float(motion.precession_ratio))) * end / 1.5) + 1
    with BallArithmetic(256) as balls:
        initial, expected = ([x for part in solution(balls, motion, balls.number(t)) for x in part] for t in (0, end))
        reached = integrate(balls, field, initial, balls.number(0), balls.number(end), steps=steps, order=55)
        scale = 1 + max(balls.magnitude(x) for x in expected)
        assert max(balls.magnitude(x - y) for x, y in zip(reached, expected, strict=True)) < 1e-45 * scale


@deterministic
@given(motions(), times)
def test_invariants_of_the_solution(motion, t):
    attitude, inertial, body = solution(AR, motion, t)
    assert abs(dot(attitude, attitude) - 1) < 1e-50
    assert near(rotate(attitude, body), inertial)
    unit, dual = particular_solution(AR, motion, t)
    assert abs(dot(unit, dual)) < AR.number("1e-45")


@deterministic
@given(motions())
def test_initial_values(motion):
    attitude, inertial, _ = solution(AR, motion, AR.number(0))
    assert near(inertial, [AR.number(x) for x in motion.initial_velocity], "1e-57")
    if motion.initial_attitude is None:
        sine, cosine = AR.sin_cos(AR.number(motion.nutation) / 2)
        assert near(attitude, [cosine, sine, 0, 0])
    else:
        wanted = [AR.number(x) for x in motion.initial_attitude]
        norm = AR.sqrt(dot(wanted, wanted))
        assert near(attitude, [x / norm for x in wanted])


def test_the_frame_offset_of_variant_3_is_the_printed_one():
    sine, cosine = AR.sin_cos(AR.pi / 36)
    assert near(frame_offset(AR, paper_motion()), [cosine, -sine, 0, 0])
    assert near(frame_offset(AR, paper_motion(initial_attitude=None)), [1, 0, 0, 0])


@deterministic
@given(motions(), st.floats(-3, 3))
def test_the_equations_of_motion_hold_term_by_term(motion, t):
    """Residuals of (1.6), (1.7) and of (1.1) for the particular solution, order by order in time."""
    series = SeriesArithmetic(AR)
    time = series.variable(AR.number(t))
    nu, eps, th = motion.principal(series)
    nu0, _, th0 = motion.dual(series)
    duals = SeriesArithmetic(series)
    arguments = [duals.variable(x, y) for x, y in ((nu, nu0), (eps, series.number(0)), (th, th0))]
    q = precession_attitude(duals, arguments, duals.constant(time))
    w = body_rate(duals, arguments, duals.constant(time))
    unit, dual, rate, force = [x[0] for x in q], [x[1] for x in q], [x[0] for x in w], [x[1] for x in w]
    zero = series.number(0)
    unit_rate = product(unit, [zero, *rate])
    dual_rate = [x + y for x, y in zip(product(dual, [zero, *rate]), product(unit, [zero, *force]), strict=True)]
    _, body = apparent_velocity(unit, dual)
    body_derivative = [x - y for x, y in zip(force, cross(rate, body), strict=True)]
    for k in range(6):
        assert near([2 * (k + 1) * x[k + 1] for x in unit], [x[k] for x in unit_rate])
        assert near([2 * (k + 1) * x[k + 1] for x in dual], [x[k] for x in dual_rate])
        assert near([(k + 1) * x[k + 1] for x in body], [x[k] for x in body_derivative])


@pytest.mark.parametrize("time", ["0", "1/3", "100", "1e6"])
def test_balls_enclose_at_any_precision(time):
    def values(ar):
        parts = solution(ar, paper_motion(initial_attitude=("0.5", "0.5", "0.1", "0.2")), ar.number(time))
        return [x for part in parts for x in part]

    with BallArithmetic(100) as coarse:
        low = values(coarse)
    with BallArithmetic(400) as fine:
        high = values(fine)
    assert all(x.overlaps(y) for x, y in zip(low, high, strict=True))
    # 30 digits less the 7 of the phase at 1e6 s and some of the operations; relative to the largest velocity.
    assert max(float(x.rad()) for x in low) < 1e-21 * max(float(abs(x)) for x in high)
