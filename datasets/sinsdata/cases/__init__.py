"""Cases: named, validated, exactly given inputs of the datasets.

A float parameter means the binary64 it is, a string what it says (`sinsref.exact`). A bad value raises
`CaseError`, which names the field, the value and what is admissible.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from sinsdata.cases.base import CaseError, whole_intervals
from sinsdata.cases.equator import EquatorCase
from sinsdata.cases.error_equations import ErrorEquationCase
from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.cases.mast import MastCase
from sinsdata.cases.precession import DualPrecessionCase

__all__ = [
    "CASE_CLASSES",
    "Case",
    "CaseError",
    "DualPrecessionCase",
    "EquatorCase",
    "ErrorEquationCase",
    "GyroCase",
    "MastCase",
    "whole_intervals",
]

#: A case of any dataset.
Case: TypeAlias = EquatorCase | DualPrecessionCase | ErrorEquationCase | GyroCase | MastCase

#: The class of the cases of each dataset.
CASE_CLASSES: Mapping[str, type[EquatorCase | DualPrecessionCase | ErrorEquationCase | GyroCase | MastCase]] = {
    "equator_errors": EquatorCase,
    "dual_precession": DualPrecessionCase,
    "error_equations": ErrorEquationCase,
    "gyro_systems": GyroCase,
    "mast_antenna": MastCase,
}
