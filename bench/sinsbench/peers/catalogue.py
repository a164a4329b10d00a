"""What is known of the published packages, read from the data file beside this module."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any

__all__ = [
    "CATALOGUE",
    "ENVIRONMENTS",
    "METHODS",
    "CatalogueError",
    "Package",
    "Peer",
    "known_packages",
    "packages",
    "peers_of",
    "read_catalogue",
]

CATALOGUE = Path(__file__).with_name("peers.toml")
"""The data file."""

ENVIRONMENTS = {"current": "numpy", "numpy1": "numpy<2"}
"""Names of the environments, and what is installed in each before any package."""

METHODS = {
    "exponential": "exp(a), a the angle increment or the mean rate times the interval: no coning term",
    "recursive": "exp(a + a' x a / 12), a' the increment before: coning as by Savage 1998 from two samples",
    "linear": "exp((w' + w) h / 2 + w' x w h^2 / 12) from the rates w', w at the ends of a sample",
    "trapezoid": "exp((w' + w) h / 2) from the rates w', w at the ends of a sample",
    "end rate": "exp(w h) from the rate w at the end of a sample",
    "Euler": "(1, a / 2), normalised: turns by 2 atan(n / 2) in place of the norm n of a",
    "spline": "the differential equation, solved with a cubic spline through the rates",
}
"""What one sample turns the attitude by."""


class CatalogueError(ValueError):
    """A data file does not hold what it should, or a name is none of its names."""


@dataclass(frozen=True)
class Peer:
    """A way in which a package integrates, as a subject.

    Attributes
    ----------
    name : str
    adapter : str
        File of the folder of adapters without its suffix, and function: ``ahrs_adapter:closed``.
    takes : str
        Input convention.
    method : str
        One of `METHODS`: what this convention makes of the inputs.
    convention : str
        What the package's documentation or code says of quaternions and rates.
    order : int
        Order of convergence that this convention gives.
    order_coning : int or None
        That on pure coning, where it is another.
    velocity : bool
        Whether it computes the apparent velocity too.
    """

    name: str
    adapter: str
    takes: str
    method: str
    convention: str
    order: int
    order_coning: int | None = None
    velocity: bool = False


@dataclass(frozen=True)
class Package:
    """A published package.

    Attributes
    ----------
    distribution : str
        Its name on the package index.
    imports : tuple of str
        Modules that the adapter imports beside NumPy.
    environment : str
        One of `ENVIRONMENTS`.
    documentation : str
        Address of its documentation.
    subjects : tuple of Peer
    adapters : Path
        Folder of the adapters.
    """

    distribution: str
    imports: tuple[str, ...]
    environment: str
    documentation: str
    subjects: tuple[Peer, ...]
    adapters: Path

    def target(self, peer: Peer) -> str:
        """Return where the code of one of its subjects is: ``path/to/file.py:name``."""
        module, _, function = peer.adapter.partition(":")
        return f"{self.adapters / module}.py:{function}"


def _made(kind: type[Any], entry: dict[str, Any], where: str, **given: Any) -> Any:
    known = {field.name for field in fields(kind)} - set(given)
    if unknown := sorted(set(entry) - known):
        raise CatalogueError(f"{where}: unknown key {', '.join(unknown)}; admissible: {', '.join(sorted(known))}")
    try:
        return kind(**entry, **given)
    except TypeError as error:
        raise CatalogueError(f"{where}: {error}") from None


def read_catalogue(path: Path) -> tuple[Package, ...]:
    """Read a data file of packages; the adapters lie in the folder ``adapters`` beside it.

    Parameters
    ----------
    path : Path

    Raises
    ------
    CatalogueError
        If a key is unknown or missing, an environment is unknown, or a name is given twice.
    """
    made: list[Package] = []
    for entry in tomllib.loads(path.read_text(encoding="utf-8"))["package"]:
        where = f"{path.name}, {entry.get('distribution', 'a package without a name')}"
        own = tuple(_made(Peer, subject, where) for subject in entry.pop("subject", ()))
        entry["imports"] = tuple(entry.get("imports", ()))
        package = _made(Package, entry, where, subjects=own, adapters=path.parent / "adapters")
        if package.environment not in ENVIRONMENTS:
            raise CatalogueError(
                f"{where}: unknown environment {package.environment!r}; admissible: {', '.join(ENVIRONMENTS)}"
            )
        made.append(package)
        for peer in own:
            if peer.method not in METHODS:
                raise CatalogueError(
                    f"{where}: unknown method {peer.method!r} of {peer.name}; admissible: {', '.join(METHODS)}"
                )
    names = [peer.name for package in made for peer in package.subjects]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise CatalogueError(f"{path.name}: given twice: {', '.join(twice)}")
    return tuple(made)


@cache
def packages() -> tuple[Package, ...]:
    """Return the published packages."""
    return read_catalogue(CATALOGUE)


def known_packages(names: Sequence[str], known: Sequence[Package]) -> tuple[Package, ...]:
    """Return packages by name of distribution or subject; all of them for no name.

    Raises
    ------
    CatalogueError
        For an unknown name.
    """
    chosen = [package for package in known if not names]
    for name in names:
        found = [one for one in known if name in (one.distribution, *(peer.name for peer in one.subjects))]
        if not found:
            raise CatalogueError(
                f"there is no package {name!r}; admissible: {', '.join(one.distribution for one in known)}"
            )
        chosen += [one for one in found if one not in chosen]
    return tuple(chosen)


def peers_of(names: Sequence[str], known: Sequence[Package]) -> tuple[tuple[Package, Peer], ...]:
    """Return subjects, each with its package, by name of subject or distribution; all of them for no name.

    Raises
    ------
    CatalogueError
        For an unknown name.
    """
    return tuple(
        (package, peer)
        for package in known_packages(names, known)
        for peer in package.subjects
        if not names or peer.name in names or package.distribution in names
    )
