"""What mutants are tried on: cases for the score that hide nothing, quick ones first, and random inputs.

A mutant is told apart where the score of a case shows a difference beyond rounding. What no case shows is compared
with the right subject on random inputs, without a score: a mutant that differs there has survived.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.formulas import COMPONENTS, EquatorReference, equator_reference, score_formula
from sinsbench.scoring.integrators import Rung, ladder, score_integrator
from sinsbench.subjects.equator_model import EARTH_RADIUS, EARTH_RATE, EQUATORIAL_GRAVITY, EquatorMotion
from sinsbench.subjects.loading import LoadedSubject
from sinsdata.cases import DualPrecessionCase, EquatorCase

__all__ = [
    "PROBED_STEPS",
    "Probe",
    "Row",
    "Trial",
    "formula_probes",
    "formula_trials",
    "integrator_probes",
    "integrator_trials",
    "score_trial",
]

Array = NDArray[np.float64]
Row: TypeAlias = Mapping[str, Any]

_SEED = 1989
PROBED_STEPS = 3
"""Number of steps of the random inputs for integrators."""


@dataclass(frozen=True)
class Trial:
    """A case to score on.

    Attributes
    ----------
    case : DualPrecessionCase or EquatorCase
    reference : tuple of Rung or EquatorReference
        What the score needs to know of it.
    scales : mapping of str to float
        Fields of a row that are compared, and the size of the result whose error each is.
    terms_only : bool
        Whether it is for defects in terms alone: long sums, which show what becomes of their rounding errors.
        Constants show in a step.
    """

    case: DualPrecessionCase | EquatorCase
    reference: tuple[Rung, ...] | EquatorReference
    scales: Mapping[str, float]
    terms_only: bool = False


def score_trial(loaded: LoadedSubject, trial: Trial) -> list[dict[str, Any]]:
    """Score a subject on a trial, as `sinsbench score` does, without times."""
    if isinstance(trial.case, EquatorCase) and isinstance(trial.reference, EquatorReference):
        return score_formula(loaded, trial.case, trial.reference, repetitions=0)
    assert isinstance(trial.case, DualPrecessionCase)
    assert not isinstance(trial.reference, EquatorReference)
    return score_integrator(loaded, trial.case, trial.reference, repetitions=0)


# Integrators

#: Duration of a step in seconds: the body turns by 0.97 rad (general) and 0.65 rad (coning), the most for which power
#: series replace closed forms. Coarse: the terms of high order are as large as they can be.
_STEP = Fraction(73, 100)

_TURNED = ("1/10", "7/10", "1/2", "1/2")  # of norm 1 exactly
_GENERAL: dict[str, Any] = {
    "spin_rate": "1",
    "precession_ratio": "1/2",
    "nutation": "1",
    "spin_rate_dual": "3",
    "nutation_dual": "2",
    "initial_velocity": ("3", "-2", "5"),
    "initial_attitude": _TURNED,
}
#: Little force: what depends on the rate of turn alone must not be left to the size of the force.
_LIGHT = _GENERAL | {
    "spin_rate_dual": "1/1000",
    "nutation_dual": "1/1000",
    "initial_velocity": ("1/1000", "1/1000", "1/1000"),
}
_CONING = _GENERAL | {"spin_rate": "3", "precession_ratio": "-1", "nutation": "3/10"}
#: Bodies that hardly turn while a large velocity grows by the same amount in every step: the rounding of the sums is
#: the same each time, up to half a unit in the last place, and adds up to what carried rounding errors avoid. Each
#: component that changes stands in one of them beside one that does not, whose carried error is zero: to take back
#: another component's error than one's own helps there as little as to take back none.
_SUMS = _GENERAL | {
    "spin_rate": "1/878000000",
    "precession_ratio": "0",
    "nutation": "pi/2",
    "spin_rate_dual": "1/70",
    "nutation_dual": "0",
    "initial_velocity": ("1300000", "-1700000", "1100000"),
}
_CARRIED: Mapping[str, dict[str, Any]] = {
    "q_w and q_z and third velocity": {"initial_attitude": ("4/5", "0", "0", "3/5")},
    "q_x and q_y": {"initial_attitude": ("0", "3/5", "4/5", "0")},
    "q_y": {"initial_attitude": ("0", "1/3", "2/3", "2/3"), "precession_ratio": "1", "spin_rate": "1/103117000000"},
    "first velocity": {"initial_attitude": ("1/2", "1/2", "1/2", "1/2")},
    "second velocity": {"initial_attitude": ("1/2", "-1/2", "-1/2", "-1/2")},
}


@dataclass(frozen=True)
class _Motion:
    """A named motion, the duration of a step in seconds, the number of steps."""

    name: str
    motion: dict[str, Any]
    step: Fraction
    steps: int


_MOTIONS = (
    _Motion("one step", _GENERAL, _STEP, 1),
    _Motion("coarse", _GENERAL, _STEP, 2),
    _Motion("large rotations", _GENERAL, 3 * _STEP, 2),
    _Motion("very large rotations", _GENERAL, 5 * _STEP, 2),
    _Motion("rapid precession", _GENERAL, 13 * _STEP / 2, 2),
    _Motion("little force", _LIGHT, 3 * _STEP, 2),
    _Motion("coning", _CONING, _STEP, 2),
    _Motion("rapid coning", _CONING, 3 * _STEP, 2),
    _Motion("very rapid precession", _GENERAL, 15 * _STEP / 2, 2),
)
_SUMMED = tuple(_Motion(f"sums of {name}", _SUMS | values, _STEP, 200) for name, values in _CARRIED.items())


@cache
def integrator_trials(samples_per_step: int, carries: bool = True) -> tuple[Trial, ...]:
    """Return the trials of integrators.

    Parameters
    ----------
    samples_per_step : int
        Number of samples that a step consumes.
    carries : bool
        Whether rounding errors may be carried from step to step, so that trials are needed which show them.
    """
    trials = []
    for one in (*_MOTIONS, *(_SUMMED if carries else ())):
        sampling = {"interval": one.step / samples_per_step, "duration": one.step * one.steps}
        given = one.motion | {key: f"{value.numerator}/{value.denominator}" for key, value in sampling.items()}
        case = DualPrecessionCase(name=one.name.replace(" ", "_"), **given)
        rungs = ladder(case, (Fraction(1),))
        speed = max(float(np.linalg.norm(rung.motion.velocity_inertial, axis=1).max()) for rung in rungs)
        angles = ("attitude_error_max", "attitude_error_end", "quaternion_norm_error_max")
        speeds = [f"velocity_{of}error_{which}" for of in ("", "body_") for which in ("max", "end")]
        trials.append(Trial(case, rungs, dict.fromkeys(angles, 1.0) | dict.fromkeys(speeds, speed), one in _SUMMED))
    return tuple(trials)


# Solvers of the equator error equations

_ERRORS = ("1/100", "-1/50", "3/200", "1", "3e-7", "1.57e-7")
_MISALIGNMENT = (("1e-5", "7e-5", "-5e-5"), ("2e-5", "3e-5", "4e-5"), ("-3e-5", "6e-5", "-2e-5"))
_FIRST_QUADRANT = ("0.01", "-0.01", "0.01", "-1", "-1e-7", "1e-7")  # every phase within pi/2 of zero


def _zero_near(speed: float, quantity: Callable[[EquatorMotion], float]) -> float:
    """Return the binary64 speed, m/s, nearest to another at which a quantity of the motion at no height is zero."""
    speeds = speed + np.arange(-400, 401) * np.spacing(speed)
    return float(min((v for v in speeds if quantity(EquatorMotion.at(v, 0.0)) == 0), key=lambda v: abs(v - speed)))


_STATIONARY = -EARTH_RATE * EARTH_RADIUS
_RESONANT = float(np.sqrt(EQUATORIAL_GRAVITY * EARTH_RADIUS)) + _STATIONARY
_WEIGHTLESS = EARTH_RADIUS * float(np.sqrt(EARTH_RATE**2 + EQUATORIAL_GRAVITY / EARTH_RADIUS)) + _STATIONARY

#: Speed, m/s; height, m; interval, s; number of epochs after the start; initial errors.
_Flight: TypeAlias = tuple[str | float, str | float, str, int, tuple[str, ...]]
#: Short enough for solvers that go step by step, and nothing to divide by.
_SHORT: tuple[_Flight, ...] = (("600", "10000", "12", 8, _ERRORS), ("600", "10000", "500", 2, _ERRORS))
_LONG: tuple[_Flight, ...] = (
    ("600", "10000", "900", 8, _ERRORS),
    ("10", "0", "900", 8, _FIRST_QUADRANT),
    ("-8363.2", "1000", "900", 8, _ERRORS),
    # Where formulas divide by what is zero or nearly so: no rotation in inertial space, no specific force, the limits
    # of the real modes, the resonance of the northern channel and that of the second harmonic, no stiffness in height.
    (_STATIONARY, "0", "900", 8, _ERRORS),
    ("-464.97", "0", "900", 8, _ERRORS),
    (_zero_near(_WEIGHTLESS, lambda motion: motion.specific_force), "0", "900", 8, _ERRORS),
    ("7433.27", "0", "900", 8, _ERRORS),
    ("7446.951262", "0", "900", 8, _ERRORS),
    ("7700", "0", "900", 8, _ERRORS),
    ("8000", "0", "900", 8, _ERRORS),
    (_zero_near(_RESONANT, lambda motion: motion.schuler_rate**2 - motion.inertial_rate**2), "0", "900", 8, _ERRORS),
    ("3644.272", "0", "900", 8, _ERRORS),
)
#: Flights that show what a control of the step does.
_CONTROLLED: tuple[_Flight, ...] = (
    # Errors that stay so small that the absolute tolerance binds, be it 1e-20.
    ("600", "10000", "100", 12, tuple(f"({x})*1e-15" for x in _ERRORS)),
    # Errors that grow, so that first the absolute tolerance binds and then the relative one, and some steps fail.
    ("600", "10000", "900", 12, tuple(f"({x})*1e-5" for x in _ERRORS)),
    ("600", "10000", "1/2", 12, _ERRORS),  # instants closer together than one second
    # The first step is within a thousandth of that at which its estimate begins to bind ...
    ("600", "10000", "81.508", 12, ("1", "1", "1", "700", "3e-5", "1e-5")),
    # ... and what is left for the last within a thousandth of that up to which it is stretched.
    ("600", "10000", "55.854", 12, _ERRORS),
    ("600", "10000", "12", 1, _ERRORS),  # a single instant
)
#: Flights by how a solver works.
_FLIGHTS: Mapping[str, tuple[_Flight, ...]] = {
    "closed form": (*_SHORT, *_LONG),
    "library": _SHORT,
    "controlled": (*_SHORT, *_CONTROLLED),
}


@cache
def formula_trials(way: str) -> tuple[Trial, ...]:
    """Return the trials of solvers, each flight without and with a misalignment.

    Parameters
    ----------
    way : {"closed form", "library", "controlled"}
        How the solver works: by formulas; step by step in a library, which takes its time and is not planted in; step
        by step under a control of the step that is.
    """
    trials = []
    for number, (v_east, height, interval, epochs, errors) in enumerate(_FLIGHTS[way]):
        for forced in (False, True):
            given: dict[str, Any] = {
                "v_east": v_east,
                "height": height,
                "interval": interval,
                "duration": f"{interval}*{epochs}",
                "initial_errors": errors,
                "misalignment": _MISALIGNMENT if forced else None,
                "inertial_longitude": "7/10",
            }
            case = EquatorCase(name=f"flight_{number}{'_misaligned' if forced else ''}", **given)
            reference = equator_reference(case)
            sizes = np.abs(reference.truth.state).max(axis=0)
            scales = {f"error_{name}_max": float(size) for name, size in zip(COMPONENTS, sizes, strict=True)}
            trials.append(Trial(case, reference, scales))
    return tuple(trials)


# Random inputs

Probe: TypeAlias = tuple[tuple[Any, ...], Mapping[str, Any]]
"""Arguments by position and by name."""


def integrator_probes(samples_per_step: int) -> list[Probe]:
    """Return increments of random rates for integrators that consume so many samples in a step.

    The rates are cubic polynomials: smooth as those of a motion, and different in every step.
    """
    random = np.random.default_rng(_SEED)
    steps, degree = PROBED_STEPS, 3
    middles = (np.arange(samples_per_step) + 0.5) / samples_per_step * 2 - 1
    powers = middles[:, None] ** np.arange(degree + 1) / samples_per_step
    probes: list[Probe] = []
    for size in (0.2, 0.99, 2.5):  # largest rotation of a step, rad
        angle, velocity = powers @ random.uniform(-1, 1, (2, steps, degree + 1, 3))
        angle *= size / np.linalg.norm(angle, axis=2).sum(axis=1).max()
        attitude = random.normal(size=4)
        start = attitude / np.linalg.norm(attitude), random.uniform(-9, 9, 3)
        probes.append(((angle.reshape(-1, 3), velocity.reshape(-1, 3), 0.01, *start), {}))
    return probes


#: Duration of random flights by how a solver works, s, and sizes of their errors: small ones meet absolute tolerances.
_DURATIONS: Mapping[str, float] = {"closed form": 3600.0, "library": 60.0, "controlled": 1200.0}
_FRACTIONS: Mapping[str, tuple[float, ...]] = {"controlled": (1.0, 1e-5, 1e-15)}


def formula_probes(way: str) -> list[Probe]:
    """Return random flights for solvers; `way` is that of `formula_trials`."""
    random = np.random.default_rng(_SEED)
    sizes = np.array([0.01, 0.01, 0.01, 1.0, 1e-7, 1e-7])
    fractions = _FRACTIONS.get(way, (1.0,))
    probes: list[Probe] = []
    for number in range(6):
        forced = {"misalignment": random.uniform(-5e-5, 5e-5, (3, 3)), "inertial_longitude": random.uniform(-3, 3)}
        time = np.sort(random.uniform(0, _DURATIONS[way], 4))
        errors = random.uniform(-1, 1, 6) * sizes * fractions[number // 2 % len(fractions)]
        flight = (time, random.uniform(-7000, 7000), random.uniform(0, 30000), errors)
        probes.append((flight, forced if number % 2 else {}))
    return probes
