"""The gyroscopic subjects as callables: ``subjects.ghc(inputs, start)``, one for each name of `catalogue.SUBJECTS`."""

import functools

from sinsbench.subjects.gyroscopic.catalogue import SUBJECTS
from sinsbench.subjects.gyroscopic.drivers import GyroscopicSubject, subject
from sinsbench.subjects.gyroscopic.systems import SYSTEMS


@functools.cache
def __getattr__(name: str) -> GyroscopicSubject:
    row = SUBJECTS.get(name)
    if row is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    function = subject(SYSTEMS[row.system], row.method)
    function.__module__, function.__name__ = __name__, name
    return function


def __dir__() -> list[str]:
    return sorted(SUBJECTS)
