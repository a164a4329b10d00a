"""A subject says which inputs it takes, and is fed these and no others."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from sinsbench.cli import run
from sinsbench.scoring.errors import attitude_error_vectors
from sinsbench.scoring.inputs import increment_errors, input_errors
from sinsbench.scoring.integrators import ladder, score_integrator
from sinsbench.scoring.score import convention_of, loaded_subjects, score
from sinsbench.subjects.integrators import panov6
from sinsbench.subjects.loading import LoadedSubject, SubjectError, resolve
from sinsbench.subjects.registry import DUAL_PRECESSION, Subject, subjects_of
from sinsdata.cases import DualPrecessionCase
from sinsdata.truth.conventions import CONVENTIONS, QUANTA
from sinsdata.truth.sampling import sample
from sinsref.exact import ExactNumber

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
GENERAL = DualPrecessionCase(
    name="general", spin_rate="2*pi", precession_ratio="0.5", nutation="pi/18", spin_rate_dual=10, nutation_dual=100,
    initial_velocity=(20, 35, 40), interval="0.01", duration="5.12",
)  # fmt: skip
CONING = replace(GENERAL, name="coning", precession_ratio=ExactNumber(-1))
FACTORS = tuple(Fraction(2) / 2**k for k in range(5))


def user(function, takes):
    return LoadedSubject(Subject("mine", None, "mine", "", takes=takes), function)


def as_increments(convention, first, second, third):
    """Inputs of any convention as increments, as well as they allow."""
    if convention == "rates":
        return (first[:-1] + first[1:]) / 2 * third, (second[:-1] + second[1:]) / 2 * third
    if convention == "mean_rates":
        return first * third, second * third
    if convention == "accumulated":
        return np.diff(first, axis=0), np.diff(second, axis=0)
    half = np.cross(first, second) / 2
    return (
        first,
        second - half if convention == "resolved_start" else second + half if convention == "resolved_end" else second,
    )


@pytest.mark.parametrize("name", CONVENTIONS)
def test_a_subject_sees_the_inputs_it_takes_and_no_others(name):
    seen = []

    def spy(first, second, third, attitude0, velocity0):
        seen.append((first, second, third, attitude0, velocity0))
        rows = len(third) - 1 if isinstance(third, np.ndarray) else round(5.12 / third)
        return np.tile(attitude0, (rows + 1, 1))

    factors = (Fraction(2), Fraction(1))
    found = score([user(spy, name)], [GENERAL], factors=factors, repetitions=0)
    assert [(row["status"], row["takes"]) for row in found] == [("ok", name)] * 2
    for (first, second, third, attitude0, velocity0), factor in zip(seen[:2], factors, strict=True):
        motion = sample(GENERAL, factor, None, name)
        assert np.array_equal(first, motion.first)
        assert np.array_equal(second, motion.second)
        assert np.array_equal(third, motion.end_times if name in ("nonuniform", "dropped") else motion.interval)
        assert np.array_equal(attitude0, motion.attitude[0])
        assert np.array_equal(velocity0, motion.velocity_inertial[0])
        others = (sample(GENERAL, factor, None, other) for other in CONVENTIONS if other != name)
        assert not any(np.array_equal(first, x.first) and np.array_equal(second, x.second) for x in others)


def test_several_subjects_are_fed_each_its_own():
    seen = {}

    def spy(name):
        def subject(first, *_):
            seen.setdefault(name, len(first))  # the first call: later ones count operations
            return np.tile([1.0, 0, 0, 0], (513, 1))

        return user(subject, name)

    score([spy("rates"), spy("increments"), spy("accumulated")], [GENERAL], factors=(Fraction(1),), repetitions=0)
    assert seen == {"rates": 513, "increments": 512, "accumulated": 513}


def test_what_is_taken(tmp_path):
    assert {subject.takes for subject in subjects_of(DUAL_PRECESSION)} == {"increments"}
    path = tmp_path / "mine.py"
    path.write_text(
        "def plain(*_): ...\ndef declared(*_): ...\ndeclared.takes = 'rates'\n"
        "def odd(*_): ...\nodd.takes = 3\ndef strange(*_): ...\nstrange.takes = 'raets'\n"
    )
    plain, declared, odd, strange = (f"{path}:{name}" for name in ("plain", "declared", "odd", "strange"))
    assert [convention_of(x) for x in loaded_subjects([plain, declared, "panov4"], DUAL_PRECESSION)] == [
        "increments", "rates", "increments",
    ]  # fmt: skip
    assert [convention_of(x) for x in loaded_subjects([plain, "panov4"], DUAL_PRECESSION, "mean_rates")] == [
        "mean_rates", "increments",
    ]  # fmt: skip
    assert convention_of(*loaded_subjects([declared], DUAL_PRECESSION, "rates")) == "rates"
    for wrong, takes, message in (
        (declared, "increments", "declares that it takes rates, not increments"),
        (
            plain,
            "raets",
            "no input convention 'raets'; admissible: increments, rates, mean_rates, accumulated, resolved_start",
        ),
        (strange, None, "no input convention 'raets'; admissible"),
        (odd, None, "takes int: the attribute must be the name of an input convention"),
        ("panov4", "rates", "built-in subjects declare what they take"),
    ):
        with pytest.raises(SubjectError, match=message):
            loaded_subjects([wrong], DUAL_PRECESSION, takes)
    with pytest.raises(SubjectError, match="belong to dual_precession"):
        loaded_subjects(["expm"], "equator_errors", "rates")


def test_the_command_line_says_what_code_takes_that_cannot(tmp_path, capsys):
    path = tmp_path / "mine.py"
    path.write_text(
        "import numpy as np\n"
        "def still(rate, force, interval, attitude0, velocity0):\n"
        "    assert len(rate) % 2 == 1\n"  # a row for the start
        "    return np.tile(attitude0, (len(rate), 1))\n"
    )
    cases = tmp_path / "cases.json"
    arguments = ["score", f"{path}:still", "--on", DUAL_PRECESSION, "--case", "variant1_coning", "--json", str(cases)]
    assert run([*arguments, "--takes", "rates"]) == 0
    assert '"takes": "rates"' in cases.read_text()
    assert run(arguments) == 1
    capsys.readouterr()
    assert run([*arguments, "--takes", "velocities"]) == 2
    assert "no input convention 'velocities'; admissible: increments, rates," in capsys.readouterr().err


def test_runge_kutta_on_point_rates_is_of_order_4():
    subject = resolve(f"{EXAMPLES / 'point_rates.py'}:runge_kutta")
    assert (subject.subject.takes, subject.subject.samples_per_step) == ("rates", 2)
    for case in (GENERAL, CONING):
        found = score([subject], [case], factors=FACTORS, repetitions=0)
        assert {row["status"] for row in found} == {"ok"}
        assert found[0]["observed_order"] == pytest.approx(4, abs=0.05)
        assert found[0]["velocity_observed_order"] == pytest.approx(4, abs=0.05)
        assert found[0]["order_points"] == len(FACTORS)


def test_unequal_samples():
    """Order 4 on coning. On general precession steps that are split off their middle add terms of random sign, an order
    lower, which grow as the square root of the number of steps: between 3 and 4. To ignore the lengths costs more."""
    subject = resolve(f"{EXAMPLES / 'nonuniform.py'}:two_unequal_samples")
    assert subject.subject.takes == "nonuniform"
    [coning, general] = (score([subject], [case], factors=FACTORS, repetitions=0) for case in (CONING, GENERAL))
    assert coning[0]["observed_order"] == pytest.approx(4, abs=0.15)
    assert 3 < general[0]["observed_order"] < 4

    def equal(angle, velocity, time, *initial):
        return subject.function(angle, velocity, np.arange(len(time)) * 0.01, *initial)

    ignorant = score([user(equal, "nonuniform")], [CONING], factors=FACTORS, repetitions=0)
    assert ignorant[-1]["attitude_error_max"] > 100 * coning[-1]["attitude_error_max"]


def held(angle, velocity, time, attitude0, velocity0):
    """Increments spread over the gaps before them: what a receiver does that holds the last value."""
    lengths = np.diff(time)
    gap = np.rint(lengths / lengths.min())[:, None]
    return one_by_one(angle * gap, attitude0)


def one_by_one(angle, attitude0):
    history = [attitude0]
    for p in angle:
        size = np.linalg.norm(p)
        w, v = np.cos(size / 2), np.sinc(size / (2 * np.pi)) / 2 * p
        a, u = history[-1][0], history[-1][1:]
        history.append(np.array([a * w - u @ v, *(a * v + w * u + np.cross(u, v))]))
    return np.array(history)


def test_dropped_samples():
    def blind(angle, velocity, time, attitude0, velocity0):
        return one_by_one(angle, attitude0)

    factors = FACTORS[:3]
    lost, bridged = (
        score([user(function, "dropped")], [GENERAL], factors=factors, repetitions=0) for function in (blind, held)
    )
    assert {row["status"] for row in (*lost, *bridged)} == {"ok"}
    for row, better in zip(lost, bridged, strict=True):
        # 2 % of 5.12 s at 9.4 rad/s are lost; spread over the gaps the increments leave what changes in a gap.
        assert row["attitude_error_max"] > 0.1
        assert better["attitude_error_max"] < 0.1 * row["attitude_error_max"]
        assert better["input_floor"] < 1e-13  # of what arrives: no floor is claimed for what does not


def test_quanta_limit_what_is_fed_by_them():
    rungs = ladder(GENERAL, (Fraction(1, 2), Fraction(1, 4)), "quantised")
    for row, exact in zip(
        score_integrator(user(panov6, "quantised"), GENERAL, rungs, 0),
        score_integrator(resolve("panov6"), GENERAL, ladder(GENERAL, (Fraction(1, 2), Fraction(1, 4))), 0),
        strict=True,
    ):
        # The floor is that of the counts themselves: the error is that, and far above what exact increments leave.
        assert row["attitude_error_max"] == pytest.approx(row["input_floor"], rel=0.05)
        assert row["attitude_error_max"] > 100 * exact["attitude_error_max"]
        assert 0.1 * QUANTA[0] < row["attitude_error_max"] < 100 * QUANTA[0]
        assert row["velocity_error_max"] > 0.1 * QUANTA[3]
        assert row["at_floor"]
        assert row["predicted_drift_deg_per_h"] is None  # that is of exact increments
    # No score is below the floor; without that limit the error is of the same size.
    motion = rungs[0].motion
    result = panov6(motion.first, motion.second, motion.interval, motion.attitude[0], motion.velocity_inertial[0])
    computed = result["attitude"][motion.checkpoints // 4]
    errors = np.linalg.norm(attitude_error_vectors(computed, motion.attitude, motion.attitude_lo), axis=1)
    assert 0.5 < errors.max() / np.linalg.norm(rungs[0].inputs.attitude, axis=1).max() < 1.5


@pytest.mark.parametrize(
    ("fed", "attitude", "velocity"), [("rates", 1.0, 1.0), ("accumulated", 1.0, 1.0), ("resolved_start", 0, 0.1)]
)
def test_conventions_are_not_interchangeable(fed, attitude, velocity):
    """An algorithm for increments on other inputs: errors of whole radians and metres per second."""

    def mistaken(first, second, interval, *initial):
        rows = len(first) - len(first) % 4
        return panov6(first[:rows], second[:rows], interval, *initial)

    [row] = score([user(mistaken, fed)], [GENERAL], factors=(Fraction(1),), repetitions=0)
    [right] = score(["panov6"], [GENERAL], factors=(Fraction(1),), repetitions=0)
    assert row["attitude_error_max"] >= attitude
    assert row["velocity_error_max"] > max(velocity, 1000 * right["velocity_error_max"])


def turned(q, v):
    t = 2 * np.cross(q[1:], v)
    return v + q[0] * t + np.cross(q[1:], t)


def transport(angle, velocity, attitude0, velocity0):
    """One rotation a sample, the velocity increment resolved in its middle: attitudes and velocities."""
    attitude = one_by_one(angle, attitude0)
    middles = (one_by_one([p / 2], q)[1] for p, q in zip(angle, attitude[:-1], strict=True))
    gains = [turned(q, v) for q, v in zip(middles, velocity, strict=True)]
    return attitude, velocity0 + np.cumsum(np.vstack([np.zeros(3), gains]), axis=0)


@pytest.mark.parametrize("name", [name for name in CONVENTIONS if name != "dropped"])
def test_floors_are_what_the_rounding_does_to_an_integrator(name):
    """Rests a million times larger are seen by an integrator in binary64: its errors change by a million floors."""
    motion = sample(GENERAL, Fraction(1), ExactNumber("0.04"), name)
    # The initial values are the same in both runs.
    floor = input_errors(
        replace(
            motion,
            attitude_lo=np.zeros_like(motion.attitude_lo),
            velocity_inertial_lo=np.zeros_like(motion.velocity_inertial_lo),
            interval_lo=0.0,
        )
    )
    enlarged, exact = 1e6, (motion.first, motion.second)
    given = motion.first - enlarged * motion.first_lo, motion.second - enlarged * motion.second_lo
    if name == "quantised":  # these errors are large as they are
        enlarged, given, exact = 1.0, exact, (motion.angle, motion.velocity)
    (attitude, velocity), (star, velocity_star) = (
        transport(*as_increments(name, *inputs, motion.interval), motion.attitude[0], motion.velocity_inertial[0])
        for inputs in (given, exact)
    )
    tilt = attitude_error_vectors(attitude, star, np.zeros_like(star))[motion.checkpoints]
    moved = (velocity - velocity_star)[motion.checkpoints]
    for computed, expected in ((floor.attitude, tilt / enlarged), (floor.velocity, moved / enlarged)):
        largest = np.abs(expected).max()
        assert largest > 1e-17
        # Transport and floor are of second order in the sample: per cent.
        assert computed == pytest.approx(expected, abs=0.03 * largest)


def test_the_rounded_interval_counts_where_rates_are_multiplied_by_it():
    motion = sample(GENERAL, Fraction(1), None, "mean_rates")
    exact = replace(motion, interval_lo=0.0)
    for given, reference, increment in zip(
        increment_errors(motion), increment_errors(exact), (motion.angle, motion.velocity), strict=True
    ):
        assert given - reference == pytest.approx(-increment * motion.interval_lo / 0.01, rel=1e-3, abs=1e-25)
    assert motion.interval_lo != 0
