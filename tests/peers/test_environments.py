"""Packages that work, fail, crash, hang or are missing: installed for real, from wheels made here, with no network."""

import os
import sys
import zipfile
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from sinsbench.peers.catalogue import known_packages, packages, read_catalogue
from sinsbench.peers.environments import environments_folder, install, installed_versions, interpreter
from sinsbench.peers.subjects import loaded_peers
from sinsbench.scoring.score import score
from sinsbench.subjects.outcome import OutcomeError
from sinsbench.subjects.processes import Limits
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber

PACKAGE = (
    '[[package]]\ndistribution = "{0}"\nimports = ["{0}"]\nenvironment = "{1}"\ndocumentation = "https://x.invalid"\n'
)
SUBJECT = (
    '[[package.subject]]\nname = "{0}.{1}"\nadapter = "{0}_adapter:{1}"\ntakes = "increments"\n'
    'method = "exponential"\nconvention = "none"\norder = 2\n'
)
ADAPTER = """
import os, time
import numpy as np
from sound import product

def right(angle, velocity, interval, attitude0, velocity0):
    return {"attitude": product(angle, attitude0)}

def raises(*arguments):
    raise RuntimeError("no such luck")

def crashes(*arguments):
    os.abort()

def hangs(*arguments):
    time.sleep(600)
"""
SOUND = """
import numpy as np

def product(angle, attitude):
    made = [attitude]
    for size, (x, y, z) in zip(np.linalg.norm(angle, axis=1), angle):
        w, (x, y, z) = np.cos(size / 2), np.sin(size / 2) / size * np.array([x, y, z])
        a, b, c, d = made[-1]
        made.append([a*w - b*x - c*y - d*z, a*x + b*w + c*z - d*y, a*y - b*z + c*w + d*x, a*z + b*y - c*x + d*w])
    return np.array(made)
"""
#: A second of the papers' coning.
SHORT = replace(paper_cases("dual_precession")[0], name="short", duration=ExactNumber("1"))


def wheel(folder: Path, name: str, files: dict[str, str]) -> None:
    """Write a wheel of version 1.0."""
    about = f"{name}-1.0.dist-info"
    contents = {
        **files,
        f"{about}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n",
        f"{about}/WHEEL": "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    contents[f"{about}/RECORD"] = "".join(f"{path},,\n" for path in [*contents, f"{about}/RECORD"])
    with zipfile.ZipFile(folder / f"{name}-1.0-py3-none-any.whl", "w") as file:
        for path, text in contents.items():
            file.writestr(path, text)


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    """Return three packages; the subjects of the first, the only one that is published, work, raise, crash and hang."""
    folder = tmp_path_factory.mktemp("catalogue")
    (folder / "adapters").mkdir()
    (folder / "adapters" / "sound_adapter.py").write_text(ADAPTER)
    (folder / "adapters" / "unpublished_adapter.py").write_text("from unpublished import f\n")
    kinds = ("right", "raises", "crashes", "hangs")
    (folder / "peers.toml").write_text(
        PACKAGE.format("sound", "current")
        + "".join(SUBJECT.format("sound", kind) for kind in kinds)
        + PACKAGE.format("unheard-of", "numpy1")
        + SUBJECT.format("unheard-of", "f")
        + PACKAGE.format("unpublished", "current")
        + SUBJECT.format("unpublished", "f")
    )
    return read_catalogue(folder / "peers.toml")


@pytest.fixture(scope="module")
def installed(tmp_path_factory, catalogue):
    """Install what can be had from an index of two wheels: the folder of the environments, and the rows."""
    index, folder = tmp_path_factory.mktemp("index"), tmp_path_factory.mktemp("environments")
    wheel(index, "sound", {"sound.py": SOUND})
    # This NumPy is a door to the one that runs the tests: nothing has to be downloaded.
    wheel(index, "numpy", {"door.pth": f"{Path(np.__file__).parents[1]}\n"})
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"NO_INDEX": "1", "FIND_LINKS": index, "CONFIG_FILE": os.devnull}.items():
            patch.setenv(f"PIP_{name}", str(value))
        seen: list[tuple[int, int, str]] = []
        chosen = known_packages(["sound", "unpublished"], catalogue)
        rows = install(chosen, folder, lambda *done: seen.append(done))
    assert seen == [(0, 2, "sound"), (1, 2, "unpublished")]
    return folder, {row.package: row for row in rows}


def test_one_package_that_fails_does_not_end_the_installation(installed):
    folder, rows = installed
    assert (rows["sound"].status, rows["sound"].version, rows["sound"].message) == ("installed", "1.0", "")
    assert rows["unpublished"].status == "failed"
    assert "unpublished" in rows["unpublished"].message
    assert "\n" not in rows["unpublished"].message
    assert "No matching distribution" in (folder / "unpublished.log").read_text()


def test_versions_are_those_of_the_environments(installed, catalogue):
    folder, _ = installed
    assert installed_versions(catalogue, folder) == {"sound": "1.0", "unheard-of": "", "unpublished": ""}


def test_whatever_a_package_does_is_a_row_and_the_others_are_scored(installed, catalogue):
    folder, _ = installed
    subjects = loaded_peers(["sound.right", "sound.raises", "sound.crashes"], catalogue, folder)
    nowhere = loaded_peers(["unheard-of", "unpublished"], catalogue, folder)
    late = loaded_peers(["sound.hangs"], catalogue, folder, Limits(timeout=1))
    factors = (Fraction(1), Fraction(1, 2))
    rows = score(["panov4", *subjects, *nowhere, *late], [SHORT], factors=factors, repetitions=1)
    found = {name: [row for row in rows if row["subject"] == name] for name in {row["subject"] for row in rows}}

    assert [row["status"] for row in found["panov4"]] == ["ok", "ok"]
    right = found["sound.right"]
    assert [row["status"] for row in right] == ["ok", "ok"]
    assert [row["version"] for row in right] == ["sound 1.0, numpy 1.0"] * 2
    # The plain exponential loses nu sin^2(theta) (nu h)^2 / 12 a second; the next term is (nu h)^2 / 20 of it.
    assert right[0]["drift_deg_per_h"] == pytest.approx(12.85, rel=0.01)
    assert all(row["ns_per_sample"] > 0 for row in right)

    def told(name, status, *words):
        assert {row["status"] for row in found[name]} == {status}
        for word in words:
            assert all(word in row["message"] for row in found[name]), found[name][0]["message"]

    told("sound.raises", "error", "RuntimeError: no such luck", "sound_adapter.py")
    told("sound.crashes", "crashed", "SIGABRT")
    told("sound.hangs", "timeout")
    told("unheard-of.f", "not installed", "sinsbench peers install unheard-of")
    # Its environment is there; the package is not.
    told("unpublished.f", "not installed", "No module named 'unpublished'", "sinsbench peers install unpublished")


def test_a_package_beside_us_needs_no_environment(tmp_path):
    here = {package.distribution: package for package in packages()}
    assert interpreter(here["scipy"], tmp_path) == Path(sys.executable)
    assert installed_versions([here["scipy"]], tmp_path)["scipy"]


def test_without_an_environment_the_command_that_makes_one_is_told(tmp_path, catalogue):
    with pytest.raises(OutcomeError, match="sinsbench peers install unpublished") as caught:
        interpreter(catalogue[-1], tmp_path)
    assert caught.value.status == "not installed"


def test_the_folder_can_be_chosen(tmp_path, monkeypatch):
    monkeypatch.setenv("SINSBENCH_PEERS", str(tmp_path))
    assert environments_folder() == tmp_path
    monkeypatch.delenv("SINSBENCH_PEERS")
    assert environments_folder().parts[-2:] == ("sinsbench", "peers")
