"""The built-in subjects as data: what each is, where it comes from, and where its code is found.

Importing this module imports none of the code it names; `sinsbench.subjects.loading` does that on demand.
"""

from dataclasses import dataclass, replace

from sinsbench.subjects.fitted_methods import FITTED_METHODS
from sinsbench.subjects.gyroscopic.catalogue import SUBJECTS as GYROSCOPIC_SUBJECTS
from sinsbench.subjects.gyroscopic.catalogue import GyroscopicRow
from sinsbench.subjects.mast.catalogue import SUBJECTS as MAST_SUBJECTS
from sinsbench.subjects.mast.catalogue import MastRow
from sinsbench.subjects.published_methods import PUBLISHED_METHODS
from sinsbench.subjects.rotation_vector_methods import METHODS, RotationVectorMethod

__all__ = ["BUILT_IN", "DUAL_PRECESSION", "EQUATOR_ERRORS", "GYRO_SYSTEMS", "MAST_ANTENNA", "Subject", "subjects_of"]

EQUATOR_ERRORS = "equator_errors"
DUAL_PRECESSION = "dual_precession"
GYRO_SYSTEMS = "gyro_systems"
MAST_ANTENNA = "mast_antenna"

_LOGINOV = "Loginov, Tkachenko, Chelnokov 2013"


@dataclass(frozen=True)
class Subject:
    """A numerical method that can be scored.

    Attributes
    ----------
    name : str
        Name by which it is asked for and reported.
    dataset : str or None
        Dataset whose contract it obeys; None for a user's subject, which obeys that of whatever it is scored on.
    target : str
        Where the callable is, ``module:attribute``.
    summary : str
        What it is, in one line.
    source : str
        Where the method was published.
    order : int or None
        Its order of convergence, where that is known; of an integrator, the order of the largest attitude error in
        general motion; of a gyroscopic system, that of the method which integrates it.
    samples_per_step : int or None
        Number of samples one step of an integrator consumes, or of the intervals between points, where that is known.
    takes : str or None
        Input convention that an integrator or gyroscopic system declares; None declares none, and is fed increments or,
        on `gyro_systems`, points.
    order_coning : int or None
        Its order on pure coning, where that is another: coefficients optimised for coning pay for it elsewhere. Those
        of a rotation-vector method have it for the drift, in the limit of a narrow cone.
    order_drift : int or None
        Order of the secular part of its attitude error on regular precession, where that is another.
    order_velocity : int or None
        Order of its velocity error, where that is another.
    state_bytes : int or None
        Size of what it carries from one step to the next: attitude, velocity (in one system of axes), carried rounding
        errors, remembered samples.
    paper : str
        The paper whose claims rest on it, as `sinsbench list papers` names it; empty for none.
    """

    name: str
    dataset: str | None
    target: str
    summary: str
    source: str = ""
    order: int | None = None
    samples_per_step: int | None = None
    takes: str | None = None
    order_coning: int | None = None
    state_bytes: int | None = None
    paper: str = ""
    order_drift: int | None = None
    order_velocity: int | None = None


_BYTES = 8  # in a number
_STATE = 4 + 3  # attitude, velocity
_REMEMBERED = 3 + 3  # angle and velocity increment of a sample


def _rotation_vector(method: RotationVectorMethod) -> Subject:
    return Subject(
        name=method.name,
        dataset=DUAL_PRECESSION,
        target=f"sinsbench.subjects.integrators:{method.name}",
        summary=method.summary,
        source=method.source,
        order=method.order,
        samples_per_step=method.samples_per_step,
        takes="increments",
        order_coning=method.order_coning,
        state_bytes=_BYTES * (_STATE + _REMEMBERED * method.history),
        order_drift=method.order_drift,
        order_velocity=method.order_velocity,
    )


def _panov(method: RotationVectorMethod, suffix: str = "", addition: str = "", carried: int = 0) -> Subject:
    subject = _rotation_vector(method)
    return replace(
        subject,
        name=subject.name + suffix,
        target=subject.target + suffix,
        summary=f"attitude and apparent velocity, order {method.order}, four samples a step{addition}",
        source="Lebedev, Panov 1989, eqs. (2.2), (2.5), (2.6)",
        state_bytes=_BYTES * (_STATE + carried),
        paper="lebedev1989",
    )


def _fitted(name: str) -> Subject:
    method = FITTED_METHODS[name]
    return Subject(
        name=name,
        dataset=DUAL_PRECESSION,
        target=f"sinsbench.subjects.fitted_integrators:{name}",
        summary=method.summary,
        source=method.source,
        order=method.order,
        samples_per_step=method.samples_per_step,
        takes="increments",
        order_coning=method.order_coning,
        state_bytes=method.state_bytes,
    )


def _equator(name: str, target: str, summary: str, source: str, order: int | None = None) -> Subject:
    return Subject(name, EQUATOR_ERRORS, f"sinsbench.subjects.{target}", summary, source, order, paper="loginov2013")


def _gyroscopic(row: GyroscopicRow) -> Subject:
    return Subject(
        name=row.name,
        dataset=GYRO_SYSTEMS,
        target=f"sinsbench.subjects.gyroscopic.subjects:{row.name}",
        summary=row.summary,
        source=row.source,
        order=row.order,
        samples_per_step=row.samples_per_step,
        takes=row.takes,
        paper="chelnokov1991",
    )


def _mast(row: MastRow) -> Subject:
    return Subject(
        name=row.name,
        dataset=MAST_ANTENNA,
        target=f"sinsbench.subjects.mast.subjects:{row.name}",
        summary=row.summary,
        source=row.source,
        paper="sokolov2024",
    )


_ODE45 = "Dormand, Prince 1980; Shampine, Reichelt 1997"

_SUBJECTS = (
    *map(_rotation_vector, PUBLISHED_METHODS.values()),
    *map(_panov, METHODS.values()),
    *(_panov(method, "_compensated", ", sums with carried rounding errors", _STATE) for method in METHODS.values()),
    *map(_fitted, FITTED_METHODS),
    _equator(
        "equator_printed",
        "equator_formulas:printed",
        "transition matrix as printed",
        f"{_LOGINOV}, (20)-(22)",
    ),
    _equator(
        "equator_corrected",
        "equator_formulas:corrected",
        "transition matrix, misprints corrected",
        f"{_LOGINOV}, (20)-(22)",
    ),
    _equator(
        "equator_general_solution",
        "equator_formulas:general_solution",
        "sum of the modes",
        f"{_LOGINOV}, (16)-(17)",
    ),
    _equator(
        "equator_amplitude_phase",
        "equator_formulas:amplitude_phase",
        "oscillations by amplitude and phase, in the right quadrant",
        f"{_LOGINOV}, (18)-(19)",
    ),
    _equator(
        "equator_amplitude_phase_printed",
        "equator_formulas:amplitude_phase_printed",
        "oscillations by amplitude and phase, principal values of the arctangents",
        f"{_LOGINOV}, (18)-(19)",
    ),
    _equator(
        "equator_robust",
        "equator_robust:robust",
        "transition matrix without vanishing denominators",
        f"{_LOGINOV}, (20)-(22), rearranged",
    ),
    _equator("expm", "equator_numerical:expm", "SciPy's matrix exponential", "Al-Mohy, Higham 2009"),
    _equator("rk45", "equator_numerical:rk45", "SciPy's RK45 at its tightest", "Dormand, Prince 1980", 5),
    _equator(
        "dop853",
        "equator_numerical:dop853",
        "SciPy's DOP853 at its tightest",
        "Hairer, Norsett, Wanner 1993",
        8,
    ),
    _equator("radau", "equator_numerical:radau", "SciPy's Radau at its tightest", "Hairer, Wanner 1996", 5),
    _equator("lsoda", "equator_numerical:lsoda", "SciPy's LSODA at its tightest", "Petzold 1983"),
    *(
        _equator(f"ode45_{name}", f"ode45:ode45_{attribute}", f"MATLAB's ode45 at RelTol = {tolerance}", _ODE45, 5)
        for name, attribute, tolerance in (
            ("1e-3", "1e3", "1e-3"),
            ("1e-6", "1e6", "1e-6"),
            ("1e-9", "1e9", "1e-9"),
            ("1e-12", "1e12", "1e-12"),
            ("tightest", "tightest", "2.22e-14"),
        )
    ),
    *map(_gyroscopic, GYROSCOPIC_SUBJECTS.values()),
    *map(_mast, MAST_SUBJECTS.values()),
)

BUILT_IN: dict[str, Subject] = {subject.name: subject for subject in _SUBJECTS}
"""The built-in subjects by name."""


def subjects_of(dataset: str) -> tuple[Subject, ...]:
    """Return the built-in subjects that obey the contract of a dataset."""
    return tuple(subject for subject in _SUBJECTS if subject.dataset == dataset)
