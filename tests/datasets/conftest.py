"""Datasets small enough to be made in a moment, and the tiers of the papers, made once."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import pytest

import rehearsals
from sinsdata.cases import CASE_CLASSES, Case
from sinsdata.generation import digits
from sinsdata.generation.generate import Generated, generate
from sinsdata.generation.specification import Specification
from sinsdata.tiers import paper_cases

#: Admissible cases, as the keys of a case file.
ADMISSIBLE: dict[str, dict[str, Any]] = {
    "equator_errors": {
        "name": "transport",
        "v_east": 250.0,
        "height": 5000.0,
        "duration": 600.0,
        "interval": 60.0,
        "initial_errors": [0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7],
    },
    "dual_precession": {
        "name": "cone",
        "spin_rate": "2*pi",
        "precession_ratio": "1/3",
        "nutation": "pi/18",
        "spin_rate_dual": 0.5,
        "nutation_dual": 10,
        "initial_velocity": [10, 0, "1/7"],
        "interval": "0.1",
        "duration": 2,
    },
}

#: ``mapping(dataset, key=value, ...)``: an admissible case with some keys changed; None removes a key.
MakeMapping: TypeAlias = Callable[..., dict[str, Any]]
#: ``make_dataset(dataset, out)`` writes a small dataset of two cases.
MakeDataset: TypeAlias = Callable[[str, Path], Generated]
#: ``python(script, *arguments)`` starts a Python of its own.
StartPython: TypeAlias = Callable[..., "subprocess.Popen[str]"]


def _mapping(dataset: str, **changes: Any) -> dict[str, Any]:
    given = {**ADMISSIBLE[dataset], **changes}
    return {key: value for key, value in given.items() if value is not None}


def _two_cases(dataset: str) -> list[Case]:
    other = {
        "equator_errors": {"misalignment": [[1e-6, 2e-6, 0], ["1/3000000", 0, 0], [0, -1e-6, 0]], "duration": 240},
        "dual_precession": {"initial_attitude": [0.6, 0, 0.8, 0], "precession_ratio": -1},
    }
    build = CASE_CLASSES[dataset].from_mapping
    return [build(_mapping(dataset)), build(_mapping(dataset, name="other", **other[dataset]))]


@pytest.fixture(scope="session")
def mapping() -> MakeMapping:
    return _mapping


@pytest.fixture(scope="session")
def make_dataset() -> MakeDataset:
    return lambda dataset, out: generate(dataset, "sweep", _two_cases(dataset), out)


@pytest.fixture(scope="session", params=list(ADMISSIBLE))
def paper_dataset(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Generated:
    dataset: str = request.param
    return generate(dataset, "paper", paper_cases(dataset), tmp_path_factory.mktemp("paper"))


@pytest.fixture(scope="module")
def digits_once() -> Iterator[None]:
    """Compute the digits of the same cases once: they take most of the time of a verification."""
    compute, known = digits.digits_text, dict[str, str]()

    def once(specification: Specification) -> str:
        if specification.key not in known:
            known[specification.key] = compute(specification)
        return known[specification.key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(digits, "digits_text", once)
        yield


@pytest.fixture
def start_python() -> Iterator[StartPython]:
    """Processes that a test leaves behind, because it fails, are ended with what they started."""
    started: list[subprocess.Popen[str]] = []

    def begin(script: str, *arguments: object, **options: Any) -> subprocess.Popen[str]:
        started.append(rehearsals.start(script, *arguments, **options))
        return started[-1]

    yield begin
    for process in started:
        if process.poll() is None:
            for child in rehearsals.offspring(process):
                child.kill()
            process.kill()
        process.communicate()


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Generated:
    """What runs that are disturbed must come to."""
    return rehearsals.make(tmp_path_factory.mktemp("undisturbed"))
