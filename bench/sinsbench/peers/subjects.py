"""Packages as subjects: each call in a fresh process of the environment that holds the package."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sinsbench.peers.catalogue import Package, Peer, packages, peers_of
from sinsbench.peers.environments import environments_folder, how_to_install, interpreter
from sinsbench.subjects.isolation import run_elsewhere
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.outcome import Outcome, OutcomeError
from sinsbench.subjects.processes import Limits, Patience
from sinsbench.subjects.registry import DUAL_PRECESSION, Subject

__all__ = ["PeerFunction", "loaded_peer", "loaded_peers"]


@dataclass
class PeerFunction:
    """An integrator that calls a package's adapter elsewhere.

    Parameters
    ----------
    package : Package
    peer : Peer
    folder : Path
        Folder of the environments.
    limits : Limits
    """

    package: Package
    peer: Peer
    folder: Path
    limits: Limits
    _patience: Patience = field(default_factory=Patience, init=False)

    def __call__(self, *arguments: Any) -> Outcome:
        """Integrate.

        Raises
        ------
        OutcomeError
            See `sinsbench.subjects.isolation.run_elsewhere`; ``not installed`` also where the package is in no
            environment.
        """
        python = interpreter(self.package, self.folder)
        target, distribution = self.package.target(self.peer), self.package.distribution

        def integrate() -> Outcome:
            return run_elsewhere(python, target, arguments, limits=self.limits, distribution=distribution)

        try:
            return self._patience.wait(len(arguments[0]), integrate)
        except OutcomeError as error:
            if error.status != "not installed":
                raise
            raise OutcomeError(error.status, f"{error}: {how_to_install(self.package)}") from error


def loaded_peers(
    names: Sequence[str] = (),
    known: Sequence[Package] | None = None,
    folder: Path | None = None,
    limits: Limits | None = None,
) -> tuple[LoadedSubject, ...]:
    """Return packages as subjects.

    Parameters
    ----------
    names : sequence of str
        Subjects or distributions; all for none.
    known : sequence of Package, optional
        The published ones by default.
    folder : Path, optional
        Folder of the environments; `sinsbench.peers.environments.environments_folder` by default.
    limits : Limits, optional

    Raises
    ------
    CatalogueError
        For an unknown name.
    """
    chosen = peers_of(names, packages() if known is None else known)
    place = environments_folder() if folder is None else folder
    return tuple(
        LoadedSubject(
            Subject(
                peer.name,
                DUAL_PRECESSION,
                package.target(peer),
                f"{package.distribution}: {peer.convention}",
                source=package.documentation,
                order=peer.order,
                samples_per_step=1,
                takes=peer.takes,
                order_coning=peer.order_coning,
            ),
            PeerFunction(package, peer, place, limits or Limits()),
            elsewhere=True,
        )
        for package, peer in chosen
    )


def loaded_peer(name: str) -> LoadedSubject | None:
    """Return the published package's subject of a name; None if there is none of that name."""
    known = any(name == peer.name for package in packages() for peer in package.subjects)
    return loaded_peers([name])[0] if known else None
