"""Virtual environments that the packages are installed in, and which interpreter runs a package."""

from __future__ import annotations

import importlib.metadata
import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from sinsbench.peers.catalogue import ENVIRONMENTS, Package
from sinsbench.subjects.outcome import OutcomeError

__all__ = [
    "FOLDER_VARIABLE",
    "Installed",
    "environments_folder",
    "how_to_install",
    "install",
    "installed_versions",
    "interpreter",
]

FOLDER_VARIABLE = "SINSBENCH_PEERS"
"""Environment variable that takes the place of the default folder of the environments."""

_LONGEST_INSTALLATION = 1800  # s

# Names in, JSON of the versions of those that are installed out.
_ASK = """
import importlib.metadata, json, sys
there = {}
for name in sys.argv[1:]:
    try:
        there[name] = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        pass
print(json.dumps(there))
"""


@dataclass(frozen=True)
class Installed:
    """What became of the installation of a package.

    Attributes
    ----------
    package : str
    environment : str
    status : str
        ``installed`` or ``failed``.
    version : str
        Of the package, where it is installed.
    message : str
        Last line of the installer, where it failed.
    """

    package: str
    environment: str
    status: str
    version: str = ""
    message: str = ""


def environments_folder() -> Path:
    """Return the folder of the environments: `SINSBENCH_PEERS`, or ``peers`` in this user's cache."""
    if given := os.environ.get(FOLDER_VARIABLE):
        return Path(given)
    try:
        import platformdirs
    except ModuleNotFoundError:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "sinsbench" / "peers"
    return Path(platformdirs.user_cache_dir("sinsbench")) / "peers"


def _python(folder: Path, environment: str) -> Path:
    return folder / environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def _is_here(package: Package) -> bool:
    try:
        importlib.metadata.version(package.distribution)
    except importlib.metadata.PackageNotFoundError:
        return False
    return True


def how_to_install(package: Package) -> str:
    """Return the command that installs a package."""
    return f"sinsbench peers install {package.distribution}"


def interpreter(package: Package, folder: Path) -> Path:
    """Return the interpreter that runs a package: this one where the package is installed, or its environment's.

    Parameters
    ----------
    package : Package
    folder : Path
        Folder of the environments.

    Raises
    ------
    OutcomeError
        ``not installed``, if there is neither.
    """
    if _is_here(package):
        return Path(sys.executable)
    python = _python(folder, package.environment)
    if not python.exists():
        raise OutcomeError("not installed", f"there is no environment for it: {how_to_install(package)}")
    return python


def _run(command: Sequence[str | Path], timeout: float | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, errors="replace", check=False, timeout=timeout
    )


def installed_versions(packages: Sequence[Package], folder: Path) -> dict[str, str]:
    """Return the versions of packages where they would run, by distribution; empty where one is not installed."""
    versions = {package.distribution: "" for package in packages}
    for package in filter(_is_here, packages):
        versions[package.distribution] = importlib.metadata.version(package.distribution)
    for environment in {package.environment for package in packages}:
        python = _python(folder, environment)
        wanted = [one.distribution for one in packages if one.environment == environment]
        missing = [name for name in wanted if not versions[name]]
        if missing and python.exists():
            asked = _run([python, "-I", "-c", _ASK, *missing])
            versions |= json.loads(asked.stdout) if not asked.returncode else {}
    return versions


def _pip(python: Path, log: Path, *requirements: str) -> str:
    """Install requirements and return nothing, or the line that says why it failed."""
    command: list[str | Path] = [
        python,
        "-m",
        "pip",
        "install",
        "--disable-pip-version-check",
        "--no-input",
        *requirements,
    ]
    try:
        done = _run(command, timeout=_LONGEST_INSTALLATION)
    except subprocess.TimeoutExpired:
        return f"stopped after {_LONGEST_INSTALLATION} s"
    log.write_text(done.stdout + done.stderr, encoding="utf-8")
    if not done.returncode:
        return ""
    lines = [line.strip() for line in (done.stdout + done.stderr).splitlines() if line.strip()]
    errors = [line for line in lines if line.startswith("ERROR")]
    return (errors or lines or [f"exit status {done.returncode}"])[-1]


def _made(folder: Path, environment: str) -> str:
    """Make an environment with NumPy, if it is not there; return nothing, or why there is none."""
    python = _python(folder, environment)
    if not python.exists():
        folder.mkdir(parents=True, exist_ok=True)
        done = _run([sys.executable, "-m", "venv", folder / environment])
        if done.returncode:
            return (done.stdout + done.stderr).strip().splitlines()[-1]
    return _pip(python, folder / f"{environment}.log", ENVIRONMENTS[environment])


def install(
    packages: Sequence[Package], folder: Path, progress: Callable[[int, int, str], None] | None = None
) -> list[Installed]:
    """Install packages, each by itself: what fails is told, and the next goes on.

    Parameters
    ----------
    packages : sequence of Package
    folder : Path
        Folder of the environments; of each installation a log is left there.
    progress : callable, optional
        ``progress(done, total, what)``.
    """
    broken = {name: _made(folder, name) for name in dict.fromkeys(package.environment for package in packages)}
    rows = []
    for number, package in enumerate(packages):
        if progress is not None:
            progress(number, len(packages), package.distribution)
        python, environment = _python(folder, package.environment), package.environment
        # NumPy again, so that no package replaces the one the environment is named after.
        message = broken[environment] or _pip(
            python, folder / f"{package.distribution}.log", package.distribution, ENVIRONMENTS[environment]
        )
        version = "" if message else installed_versions([package], folder)[package.distribution]
        status = "failed" if message else "installed"
        rows.append(Installed(package.distribution, environment, status, version, message))
    return rows
