"""The table of built-in subjects names code that exists, and importing it imports none of that code."""

import subprocess
import sys

import pytest

from sinsbench.subjects.loading import resolve
from sinsbench.subjects.registry import BUILT_IN, DUAL_PRECESSION, EQUATOR_ERRORS, subjects_of

NAMES = {
    DUAL_PRECESSION: {f"panov{order}{suffix}" for order in (2, 4, 6) for suffix in ("", "_compensated")},
    EQUATOR_ERRORS: {
        *(f"equator_{x}" for x in ("printed", "corrected", "general_solution", "amplitude_phase", "robust")),
        *("equator_amplitude_phase_printed", "expm", "rk45", "dop853", "radau", "lsoda"),
        *(f"ode45_{x}" for x in ("1e-3", "1e-6", "1e-9", "1e-12", "tightest")),
    },
}


@pytest.mark.parametrize("dataset", NAMES)
def test_names(dataset):
    assert {subject.name for subject in subjects_of(dataset)} == NAMES[dataset]


def test_every_subject_belongs_to_a_dataset():
    assert set(BUILT_IN) == NAMES[DUAL_PRECESSION] | NAMES[EQUATOR_ERRORS]
    assert all(subject.name == name and subject.summary and subject.source for name, subject in BUILT_IN.items())


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_target_is_there(name):
    loaded = resolve(name)
    assert loaded.subject is BUILT_IN[name]
    assert loaded.function.__module__ == loaded.subject.target.split(":")[0]


def test_different_subjects_are_different_code():
    assert len({id(resolve(name).function) for name in BUILT_IN}) == len(BUILT_IN)


def test_importing_the_table_imports_no_heavy_module():
    check = (
        "import sys, sinsbench.subjects.registry, sinsbench.subjects.loading;"
        "sys.exit(' '.join({'numpy', 'numba', 'scipy', 'flint', 'mpmath'} & set(sys.modules)) or 0)"
    )
    result = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=False)
    assert (result.returncode, result.stderr) == (0, "")
