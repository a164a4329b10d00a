"""Relations between stored rows: they hold for what is generated, and each breaks when a digit far out is changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsdata.cases import CASE_CLASSES, Case
from sinsdata.format.schema import DATASETS
from sinsdata.generation.generate import generate
from sinsdata.generation.tables import GROUPS, Segment, TableGroup, series_batches
from sinsdata.truth.conventions import QUANTA, TABLES
from sinsdata.verification.double_double import DoubleDouble, nearest
from sinsdata.verification.invariants import CASE_INVARIANTS, INVARIANTS
from sinsdata.verification.residuals import Invariant
from sinsdata.verification.stored_rows import Stretch, TableLayout, Window, stretches
from sinsdata.verification.verify import verify
from sinsref.arithmetic import MpArithmetic
from sinsref.rounding import RoundingTally

_PRECESSION = {
    "name": "cone", "spin_rate": "2*pi", "precession_ratio": "1/3", "nutation": "pi/18", "spin_rate_dual": 0.5,
    "nutation_dual": 10, "initial_velocity": [10, 0, "1/7"], "interval": "0.01", "duration": 3,
}  # fmt: skip
_EQUATOR = {
    "name": "transport", "v_east": 250.0, "height": 5000.0, "duration": 600.0, "interval": 60.0,
    "initial_errors": [0.01, 0.02, 0.03, 1.0, 1.57e-7, 1.5e-7],
}  # fmt: skip
_FLIGHT = {
    "name": "circle", "motion": "great_circle", "latitude": 0.5, "longitude": 0, "height": 5000.0, "speed": 250.0,
    "duration": 60, "interval": 20, "initial_errors": [0.01, 0.02, 0.03, 1.0, 1.57e-7, 1.5e-7], "heading": 0.7,
}  # fmt: skip
_GIVEN: dict[str, list[dict[str, Any]]] = {
    "dual_precession": [
        _PRECESSION,
        # General attitude, a long sample, the longest initial velocity: everything off the axes.
        {**_PRECESSION, "name": "other", "initial_attitude": [0.5, 0.5, -0.5, 0.5], "precession_ratio": -1.25,
         "initial_velocity": [-3, 7, 2], "interval": 0.125, "duration": 2},
    ],
    "equator_errors": [
        _EQUATOR,
        {**_EQUATOR, "name": "tilted", "misalignment": [[1e-6, 2e-6, 0], ["1/3000000", 0, 0], [0, -1e-6, 0]]},
    ],
    "error_equations": [_FLIGHT, {**_FLIGHT, "name": "parallel", "motion": "parallel", "heading": None}],
    "gyro_systems": [
        {"name": "track", "motion": "track", "latitude": "0.9 + 1e-3*sin(2*pi*t/300)", "longitude": "0.5 + 1e-4*t",
         "duration": 40, "interval": 4},
        {"name": "orbit", "motion": "great_circle", "latitude": "pi/4", "longitude": 1, "course": "pi/3",
         "speed": "300 + 100*sin(t/50)", "altitude": "10*t", "duration": 40, "interval": 4},
    ],
    "mast_antenna": [
        {"name": "paper", "duration": "0.2", "interval": "0.01"},
        {"name": "east", "duration": "0.2", "interval": "0.02", "latitude": 1.0, "velocity_east": "300 + 20*sin(t)",
         "mast_length": 25, "vehicle_rotation": [0.5, -1, 2], "mast_rotation": [0.7, 0.4, 0],
         "fault": "specific_force1", "fault_size": 0.01, "seed": 5},
    ],
}  # fmt: skip


def _case(dataset: str, keys: dict[str, Any]) -> Case:
    return CASE_CLASSES[dataset].from_mapping({key: value for key, value in keys.items() if value is not None})


def _groups(dataset: str) -> Iterator[TableGroup]:
    """Yield what makes the tables of a dataset but ``cases``."""
    yield from GROUPS[dataset][1:]
    if dataset == "dual_precession":
        known = {table for group in GROUPS[dataset] for table in group.tables}
        for name, table in TABLES.items():
            if name not in known:
                yield TableGroup((name,), table.rows, series_batches(dataset, [name], table.blocks), None)


@cache
def _window(dataset: str) -> Window:
    cases = [_case(dataset, keys) for keys in _GIVEN[dataset]]
    parts = tuple(Stretch(case, 0, case.samples) for case in cases)
    tables = {}
    for group in _groups(dataset):
        segments = [Segment(case, 0, group.rows(case)) for case in cases]
        made = list(zip(*group.batches("test", segments, RoundingTally()), strict=True))
        for name, batches in zip(group.tables, made, strict=True):
            tables[name] = pa.concat_batches(batches)
    return Window(parts, tables)


def _excess(invariant: Invariant, window: Window) -> float:
    return max(float(residual.excess.max(initial=0)) for residual in invariant.residuals(window))


def _known(dataset: str) -> list[Invariant]:
    return [*INVARIANTS.get(dataset, ()), *CASE_INVARIANTS.get(dataset, ())]


_AVAILABLE = [dataset for dataset in INVARIANTS if dataset in DATASETS and dataset in GROUPS]


@pytest.mark.parametrize("dataset", _AVAILABLE)
def test_relations_hold_with_digits_to_spare(dataset: str) -> None:
    """But for bounds that are no roundings, a tenth of the tolerance is enough."""
    for invariant in _known(dataset):
        limit = 1.0 if "at most" in invariant.name else 0.1
        assert _excess(invariant, _window(dataset)) <= limit, invariant.name


def test_exact_zeros_of_the_initial_attitude_are_zeros(mapping: Any, tmp_path: Path) -> None:
    """cos(pi/2) is 0, of which mpmath leaves 1e-80."""
    case = CASE_CLASSES["dual_precession"].from_mapping(mapping("dual_precession", nutation="pi", duration="0.5"))
    folder = generate("dual_precession", "sweep", [case], tmp_path).folder
    assert [check for check in verify(folder) if not check.holds] == []


def _beside(relative: float) -> Callable[[float], float]:
    return lambda x: relative * x


#: Dataset, words of the name, table, column, and what is added to it: 1e-25 of it where nothing else is said.
_DEFECTS: list[tuple[str, str, str, str, Callable[[float], float]]] = [
    (dataset, words, table, column, _beside(1e-25))
    for dataset, words, table, columns in (
        ("dual_precession", "unit norm", "truth", "q_w q_x q_y q_z"),
        ("dual_precession", "body axes", "truth", "q_w w_inertial_x w_inertial_y w_body_x w_body_y w_body_z"),
        ("dual_precession", "initial values", "truth", "q_w q_x w_inertial_x w_inertial_z"),
        ("dual_precession", "unit norm", "nonuniform_truth", "q_w q_y"),
        ("dual_precession", "body axes", "nonuniform_truth", "w_inertial_x w_body_x"),
        ("dual_precession", "initial values", "nonuniform_truth", "q_w w_inertial_x"),
        ("dual_precession", "change of attitude", "increments", "angle_x angle_y angle_z"),
        ("dual_precession", "change of attitude", "increments", "velocity_x velocity_y velocity_z"),
        ("dual_precession", "change of attitude", "truth", "q_w q_x w_inertial_x w_inertial_y w_inertial_z"),
        ("dual_precession", "sums", "accumulated", "angle_x angle_z velocity_x velocity_y"),
        ("dual_precession", "means", "mean_rates", "angular_rate_x angular_rate_z specific_force_y"),
        ("dual_precession", "rates at the ends", "rates", "angular_rate_x angular_rate_z specific_force_x"),
        ("dual_precession", "resolved", "resolved", "velocity_start_x velocity_start_z velocity_end_y"),
        ("dual_precession", "lengths", "nonuniform", "interval angle_z velocity_z"),
        ("dual_precession", "arrives", "dropped", "angle_x angle_z velocity_y"),
        ("equator_errors", "initial errors", "truth", "dv_north d_height d_longitude"),
        ("equator_errors", "P(0) = I", "transition", "p11 p44 p66"),
        ("equator_errors", "misalignment", "truth", "dv_north dv_up d_height d_longitude"),
        ("equator_errors", "misalignment", "transition", "p11 p15 p44 p66"),
        ("equator_errors", "roots", "modes",
         "rho1 rho2 beta3 mu omega nu alpha6 alpha3_growing alpha3_swinging"),
        ("error_equations", "start of the motion", "motion", "v_north v_east height latitude"),
        ("error_equations", "initial errors", "truth", "dv_north d_height d_longitude"),
        ("error_equations", "linearisation", "nonlinear", "dv_north d_height d_longitude"),
        ("error_equations", "linearisation", "truth", "dv_north d_height d_longitude"),
        ("gyro_systems", "unit quaternions", "truth", "q_w q_y trihedron_x vertical_y"),
        ("gyro_systems", "Darboux", "truth", "trihedron_w vertical_x velocity_x velocity_z"),
        ("gyro_systems", "longitudes", "truth", "longitude longitude_absolute"),
        ("gyro_systems", "start of the motion", "truth", "latitude longitude radius heading pitch roll"),
        ("gyro_systems", "unit axes", "reference", "paper_gyro_x rest_mirror_y rest_bisector_z"),
        ("gyro_systems", "keep their angle", "reference", "paper_gyro_x rest_gyro_z paper_mirror_y"),
        ("gyro_systems", "half way", "reference", "paper_gyro_z rest_mirror_x paper_bisector_y rest_bisector_x"),
    )
    for column in columns.split()
]  # fmt: skip
# Values have no rests: a millionth of them, and a tenth of rates in turns, which leave room for h^5 of the motion.
_DEFECTS += [
    ("mast_antenna", words, table, column, _beside(0.1 if "rate" in column and "turns" in words else 1e-6))
    for words, table, columns in (
        ("unit quaternions", "truth", "mu_w lambda_w eta_y nu_z"),
        ("composed", "truth", "lambda_x eta_y nu_z nu_w"),
        ("start of the motion", "truth", "mu_w eta_x lambda_w longitude latitude height"),
        ("without jumps", "sensors", "end_angular_rate1_x end_specific_force1_y start_specific_force2_z"),
        ("along the mast", "sensors", "start_specific_force1_z end_specific_force2_x"),
        ("along the mast", "truth", "lambda_y eta_x mast_absolute_rate_x mast_absolute_rate_y"),
        ("rate of the antenna", "sensors", "start_angular_rate2_x end_angular_rate2_z start_angular_rate1_z"),
        ("rate of the antenna", "truth", "eta_w eta_z lambda_w mast_absolute_rate_y"),
        ("turns of the vehicle", "truth", "mu_w mu_z"),
        ("turns of the vehicle", "sensors", "middle_angular_rate1_x start_angular_rate1_x"),
        ("turns of the mast", "truth", "mu_x lambda_w mast_absolute_rate_x"),
        ("circular orbits", "satellites", "satellite1_x satellite4_velocity_z"),
        ("ranges", "satellites", "satellite2_y satellite3_velocity_x range1 range4 range_rate2"),
        ("ranges", "truth", "latitude longitude v_north v_east"),
    )
    for column in columns.split()
]
_DEFECTS += [
    # The commutators leave room for h^2 of the motion: 0.6 rad and 4 m/s a sample here, squared.
    ("dual_precession", "commutators", "increments", "angle_z", lambda x: 0.3 * x),
    ("dual_precession", "commutators", "truth", "w_inertial_x", lambda x: 2.0),
    ("dual_precession", "whole quanta", "quantised", "angle_x", lambda x: QUANTA[0]),
    ("dual_precession", "whole quanta", "quantised", "velocity_y", lambda x: -QUANTA[3]),
]
_AT_START = ("initial values", "initial errors", "P(0) = I", "start of the motion")


@pytest.mark.parametrize(
    ("dataset", "words", "table", "column", "defect"),
    [case for case in _DEFECTS if case[0] in _AVAILABLE],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_planted_defect_breaks_the_relation(
    dataset: str, words: str, table: str, column: str, defect: Callable[[float], float]
) -> None:
    (invariant,) = [known for known in _known(dataset) if words in known.name and table in known.tables]
    window = _window(dataset)
    batch = window.tables[table]
    values = np.nan_to_num(batch[column].to_numpy(zero_copy_only=False))
    # Of rows that stand for the relation: the start, those of the first case, which has no misalignment, or all.
    rows = 1 if words in _AT_START else window.parts[0].end + 1 if words == "misalignment" else None
    row = int(np.abs(values[:rows]).argmax())
    half = f"{column}_lo" if f"{column}_lo" in batch.schema.names else column
    rest = batch[half].to_numpy(zero_copy_only=False).copy()
    rest[row] += defect(values[row])
    assert rest[row] != batch[half][row].as_py(), "the defect is none"
    place = batch.schema.get_field_index(half)
    changed = batch.set_column(place, batch.schema.field(place), pa.array(rest))
    assert _excess(invariant, Window(window.parts, {**window.tables, table: changed})) > 1


def test_every_relation_has_a_planted_defect() -> None:
    for dataset in _AVAILABLE:
        planted = [words for name, words, *_ in _DEFECTS if name == dataset]
        for invariant in _known(dataset):
            assert any(words in invariant.name for words in planted), invariant.name


# The arithmetic.

_NUMBERS = st.tuples(
    st.floats(-1e20, 1e20).filter(lambda x: x == 0 or abs(x) > 1e-20), st.floats(-1, 1), st.sampled_from([-1, 1])
)


@settings(derandomize=True, deadline=None)
@given(x=_NUMBERS, y=_NUMBERS)
def test_operations_stay_within_their_majorant(x: Any, y: Any) -> None:
    """7 units of 2^-106 for a product, 3 for a sum: what the tolerance of the relations is made of."""
    ar = MpArithmetic(80)
    pairs, exact = [], []
    for high, share, _ in (x, y):
        low = float(np.spacing(abs(high))) / 2 * share
        pairs.append(nearest([ar.number(high) + ar.number(low)]))
        exact.append(ar.number(float(pairs[-1].high[0])) + ar.number(float(pairs[-1].low[0])))
    (a, b), (p, q) = exact, pairs
    for value, result, units in ((a + b, p + q, 3), (a - b, p - q, 3), (a * b, p * q, 7), (a / 2, p / 2, 0)):
        error = abs(ar.number(float(result.high[0])) + ar.number(float(result.low[0])) - value)
        assert error <= units * 2.0**-106 * float(result.majorant[0])
        assert result.majorant[0] >= abs(value) * (1 - 1e-15)


def test_majorants_are_the_sums_of_magnitudes() -> None:
    x, y = (DoubleDouble(np.array([value]), np.zeros(1)) for value in (3.0, -2.0))
    assert (x + y).majorant[0] == 5
    assert (x * y - x).majorant[0] == 9
    assert (-(x + y) * 2).majorant[0] == 10


# Windows.


@settings(derandomize=True, deadline=None, max_examples=30)
@given(samples=st.lists(st.integers(1, 40_000), min_size=1, max_size=5), table=st.sampled_from(list(TABLES)))
def test_windows_hold_every_row_once_and_samples_beside_their_ends(samples: list[int], table: str) -> None:
    cases = [
        _case("dual_precession", {**_PRECESSION, "name": f"c{n}", "interval": 0.5, "duration": 0.5 * count})
        for n, count in enumerate(samples)
    ]
    group = TableGroup((table,), TABLES[table].rows, lambda *given: iter(()), None)
    layout = TableLayout(table, group)
    rows: dict[str, list[int]] = {case.name: [] for case in cases}
    for parts in stretches(cases):
        for part in parts:
            first, end = layout.span(part)
            rows[part.case.name] += range(first, end)
            numbers = layout.epochs(part.case, np.arange(first, end))
            assert len(numbers) == 0 or part.start - (part.start == 0) < numbers[0] <= numbers[-1] <= part.end
        window = Window(parts, {})
        for end, places in ((0, window.epochs[window.before]), (1, window.epochs[window.after])):
            assert np.array_equal(places.stretch, window.samples.stretch)
            assert np.array_equal(places.epoch + 1 - end, window.samples.epoch)
    for case in cases:
        assert rows[case.name] == list(range(TABLES[table].rows(case)))
