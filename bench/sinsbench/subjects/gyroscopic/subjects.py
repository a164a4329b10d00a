"""The gyroscopic subjects as callables: ``subjects.ghc(inputs, start)``, one for each name of `catalogue.SUBJECTS`."""

from sinsbench.subjects.gyroscopic.catalogue import SUBJECTS
from sinsbench.subjects.gyroscopic.drivers import GyroscopicSubject, subject
from sinsbench.subjects.gyroscopic.systems import SYSTEMS


def __getattr__(name: str) -> GyroscopicSubject:
    row = SUBJECTS.get(name)
    if row is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return subject(SYSTEMS[row.system], row.method)


def __dir__() -> list[str]:
    return sorted(SUBJECTS)
