"""The table of built-in subjects names code that exists, and importing it imports none of that code."""

import subprocess
import sys

import numpy as np
import pytest

from sinsbench.subjects.fitted_methods import FITTED_METHODS
from sinsbench.subjects.gyroscopic.catalogue import SUBJECTS as GYROSCOPIC_SUBJECTS
from sinsbench.subjects.integrators import StreamingIntegrator
from sinsbench.subjects.loading import resolve
from sinsbench.subjects.mast.catalogue import FAULTS
from sinsbench.subjects.published_methods import PUBLISHED_METHODS
from sinsbench.subjects.registry import (
    BUILT_IN,
    DUAL_PRECESSION,
    EQUATOR_ERRORS,
    GYRO_SYSTEMS,
    MAST_ANTENNA,
    subjects_of,
)
from sinsbench.subjects.rotation_vector_methods import METHODS

NAMES = {
    DUAL_PRECESSION: {
        *(f"panov{order}{suffix}" for order in (2, 4, 6) for suffix in ("", "_compensated")),
        *("one_sample", "recursive", "two_sample", "two_sample_savage", "two_sample_savage_third", "ignagni2"),
        *("miller3", "miller3_coning", "savage3", "savage_high_rate4", "lee4", "park5"),
        *FITTED_METHODS,
    },
    EQUATOR_ERRORS: {
        *(f"equator_{x}" for x in ("printed", "corrected", "general_solution", "amplitude_phase", "robust")),
        *("equator_amplitude_phase_printed", "expm", "rk45", "dop853", "radau", "lsoda"),
        *(f"ode45_{x}" for x in ("1e-3", "1e-6", "1e-9", "1e-12", "tightest")),
    },
    GYRO_SYSTEMS: {
        *("gp_paper", "gp_equilibrium", "gpx", "bg_paper", "bg_equilibrium", "bgx", "bgv", "gf", "gf_linear"),
        *("ghc", "ghc_radius", "ghc_altitude", "full", "trad", "newton"),
        *(name for name in GYROSCOPIC_SUBJECTS if name.endswith(("_increments", "_lie", "_dop853"))),
    },
    MAST_ANTENNA: {
        *("cekf", "cekf_complete", "cekf_printed", "cekf_printed_313", "cekf_printed_root", "cekf_repaired"),
        *("mekf_eta", "mekf_nu", "mekf_eta_az", "mekf_nu_az", "relinearised_az"),
        *(f"mekf_nu_az_{fault}" for fault in FAULTS),
    },
}


@pytest.mark.parametrize("dataset", NAMES)
def test_names(dataset):
    assert {subject.name for subject in subjects_of(dataset)} == NAMES[dataset]


def test_every_subject_belongs_to_a_dataset():
    assert set(BUILT_IN) == set.union(*NAMES.values())
    assert all(subject.name == name and subject.summary and subject.source for name, subject in BUILT_IN.items())


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_target_is_there(name):
    loaded = resolve(name)
    assert loaded.subject is BUILT_IN[name]
    assert loaded.function.__module__ == loaded.subject.target.split(":")[0]


def test_different_subjects_are_different_code():
    functions = [resolve(name).function for name in BUILT_IN]
    assert len(set(map(id, functions))) == len(BUILT_IN)


def test_integrators_stand_from_the_simplest_on():
    names = [subject.name for subject in subjects_of(DUAL_PRECESSION)]
    assert names[:3] == ["one_sample", "recursive", "two_sample"]
    assert names.index("park5") < names.index("panov2") < names.index("panov6_compensated") < names.index("taylor2")


@pytest.mark.parametrize("name", [*PUBLISHED_METHODS, *METHODS, *(f"{name}_compensated" for name in METHODS)])
def test_state_is_what_a_streaming_integrator_carries(name):
    subject, compensated = BUILT_IN[name], name.endswith("_compensated")
    method = (PUBLISHED_METHODS | METHODS)[name.removesuffix("_compensated")]
    stream = StreamingIntegrator(method, [1.0, 0, 0, 0], np.zeros(3), compensated)
    numbers = sum(map(len, stream._state)) + sum(len(vector) for memory in stream._earlier for vector in memory)
    redundant = 0 if compensated else 3  # the velocity in body axes, which follows from that in inertial axes
    assert subject.state_bytes == 8 * (numbers - redundant)


def test_orders_that_differ_are_told():
    orders = {name: (s.order, s.order_drift, s.order_coning, s.order_velocity) for name, s in BUILT_IN.items()}
    assert orders["two_sample"] == (4, None, None, None)
    assert orders["two_sample_savage"] == (4, None, None, 2)
    assert orders["lee4"] == (3, 4, 8, None)
    assert all(subject.order for subject in subjects_of(DUAL_PRECESSION))


def test_importing_the_table_imports_no_heavy_module():
    check = (
        "import sys, sinsbench.subjects.registry, sinsbench.subjects.loading;"
        "sys.exit(' '.join({'numpy', 'numba', 'scipy', 'flint', 'mpmath'} & set(sys.modules)) or 0)"
    )
    result = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=False)
    assert (result.returncode, result.stderr) == (0, "")
