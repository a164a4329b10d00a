"""Estimators of the antenna on a mast that are programs, files of results or run in a process of their own."""

import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sinsbench.elsewhere.contracts import contract_of
from sinsbench.elsewhere.files import FORMATS, read_columns, write_columns
from sinsbench.elsewhere.mast import COVARIANCE, ESTIMATES, NODES, MastContract
from sinsbench.elsewhere.programs import program
from sinsbench.elsewhere.results import result_file
from sinsbench.scoring.mast import first_steps, score_mast
from sinsbench.scoring.mast_errors import inputs_of, start_of
from sinsbench.subjects.isolated import isolated_subject
from sinsbench.subjects.loading import LoadedSubject, SubjectError, resolve
from sinsbench.subjects.mast.contract import ERRORS, MastConstants, MastInputs, MastNoise, MastStart
from sinsbench.subjects.processes import Limits
from sinsbench.subjects.registry import MAST_ANTENNA, Subject
from sinsdata.cases import MastCase
from sinsdata.format.mast_columns import MAST_ANTENNA as SCHEMA
from sinsdata.format.mast_columns import NODES as STORED_NODES
from sinsdata.truth.mast import MastMotion, sampled

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
CALLABLE = f"{EXAMPLES / 'mast_gyros.py'}:gyros_alone"
PROGRAM = f'"{sys.executable}" -S "{EXAMPLES / "mast_gyros_program.py"}"'
SECONDS, SATELLITES = 3, 2
Row = dict[str, Any]
Table = dict[str, Any]


@pytest.fixture(scope="module")
def case() -> MastCase:
    return MastCase("brief", str(SECONDS), "0.01", satellites_used=str(SATELLITES))


@pytest.fixture(scope="module")
def truth(case: MastCase) -> MastMotion:
    return sampled(case)


@pytest.fixture(scope="module")
def arguments(truth: MastMotion) -> tuple[MastInputs, MastStart]:
    return inputs_of(truth), start_of(truth.start)


@pytest.fixture(scope="module")
def result(truth: MastMotion) -> dict[str, Any]:
    """Return what an estimator that knows the truth could return, with a covariance that is not diagonal."""
    rows = slice(None, None, 200)
    names = {name: "lam" if name == "lambda" else name for name in ("time", *ESTIMATES)}
    root = np.tril(np.full((ERRORS, ERRORS), 0.1)) + np.eye(ERRORS)
    scale = np.where(truth.start.sds > 0, truth.start.sds, 1e-3)
    # The products with both deviations round differently on the two sides of the diagonal.
    covariance = np.triu(scale[:, None] * (root @ root.T) * scale)
    covariance += np.triu(covariance, 1).T
    count = SECONDS + 1
    return {name: getattr(truth, attribute)[rows].copy() for name, attribute in names.items()} | {
        "covariance": np.tile(covariance, (count, 1, 1)),
        "nis": 16.0 * np.arange(count),
        "nis_freedom": 15.0 * np.arange(count),
    }


@pytest.fixture(scope="module")
def table(result: dict[str, Any]) -> Table:
    """The same as a table of results."""
    columns: Table = {"case": ["brief"] * (SECONDS + 1), "time": result["time"]}
    for name, components in ESTIMATES.items():
        columns |= dict(zip(components, np.reshape(result[name], (SECONDS + 1, -1)).T, strict=True))
    upper = [result["covariance"][:, i, j] for i in range(ERRORS) for j in range(i, ERRORS)]
    return columns | dict(zip(COVARIANCE, upper, strict=True)) | {n: result[n] for n in ("nis", "nis_freedom")}


def test_a_table_holds_all_that_a_callable_is_given(arguments: tuple[MastInputs, MastStart]) -> None:
    inputs, start = arguments
    given = contract_of(MAST_ANTENNA, None).table(arguments, {})

    def vectors(stem: str, axes: str = "xyz") -> np.ndarray[Any, Any]:
        return np.column_stack([given[f"{stem}_{axis}"] for axis in axes])

    def nodes(stem: str) -> np.ndarray[Any, Any]:
        return np.stack([vectors(f"{node}_{stem}") for node in NODES], axis=1)

    for stem, name in (("angular_rate", "rate"), ("specific_force", "specific_force")):
        for group in "12":
            np.testing.assert_array_equal(nodes(f"{stem}{group}"), getattr(inputs, f"{name}{group}"))
    for n in range(SATELLITES):
        for stem, name in ((f"satellite{n + 1}", "position"), (f"satellite{n + 1}_velocity", "velocity")):
            expected = getattr(inputs, f"satellite_{name}")[:, n]
            for k, read in enumerate(np.moveaxis(nodes(stem), 1, 0)):
                np.testing.assert_array_equal(read, expected[k : k + 2 * len(read) : 2])
        for name in ("range_rate", "range"):
            read = np.column_stack([given[f"{node}_{name}{n + 1}"] for node in NODES])
            np.testing.assert_array_equal(read, getattr(inputs, name)[:, :, n])
    np.testing.assert_array_equal(given["time"], inputs.time[1:])
    first = {name: values[0] for name, values in given.items()}
    assert first["interval"] == inputs.step
    noise = [first[f"{name}_sd"] for name in ("gyro", "accelerometer")] * 2
    noise += [first[f"{name}_sd"] for name in ("antenna_rate", "range_rate", "range")]
    assert MastNoise(*noise) == inputs.noise
    constants = (first[name] for name in ("mast_length", "radius", "rotation_rate", "gravity"))
    assert MastConstants(*constants) == inputs.constants
    deviations = [value for name, value in first.items() if name.startswith("sd0_")]
    same = MastStart(
        vectors("mu0", "wxyz")[0],
        first["longitude0"],
        first["latitude0"],
        np.array([first[f"v_{name}0"] for name in ("east", "north", "up")]),
        first["height0"],
        vectors("eta0", "wxyz")[-1],
        vectors("lambda0", "wxyz")[0],
        vectors("mast_absolute_rate0", "xy")[0],
        np.array(deviations),
    )
    for field in fields(MastStart):
        np.testing.assert_array_equal(getattr(same, field.name), getattr(start, field.name))


def test_columns_are_called_as_in_the_dataset(arguments: tuple[MastInputs, MastStart], table: Table) -> None:
    assert tuple(STORED_NODES) == NODES
    stored = {name: {column.name for column in columns} for name, columns in SCHEMA.tables.items()}
    bare = {name.partition("_")[2] for name in MastContract().table(arguments, {}) if name.startswith(NODES)}
    known = stored["satellites"] | {name.removeprefix("start_") for name in stored["sensors"]}
    assert len(bare) == 4 * 3 + SATELLITES * 8
    assert bare <= known
    estimates = {name for names in ESTIMATES.values() for name in names}
    assert estimates | {f"nu_{axis}" for axis in "wxyz"} | {"case", "time"} == stored["truth"]


def test_the_example_estimates_as_its_callable_does(arguments: tuple[MastInputs, MastStart]) -> None:
    outcome = program(PROGRAM, MAST_ANTENNA).function(*arguments)
    expected = resolve(CALLABLE).function(*arguments)
    assert set(outcome.result) == set(expected)
    for name, values in expected.items():
        # A rounding or two a step, of numbers of at most 1 but for the height and the velocity.
        np.testing.assert_allclose(outcome.result[name], values, rtol=1e-13, atol=1e-13, err_msg=name)
    assert all(seconds > 0 for seconds in outcome.seconds)


def test_the_shortest_run_goes_to_the_second_row(arguments: tuple[MastInputs, MastStart]) -> None:
    (inputs, start), part = MastContract().shortest(arguments, SECONDS + 1)
    assert inputs.checked().time[-1] == 1
    assert start is arguments[1]
    assert part == pytest.approx(1 - 1 / SECONDS)
    assert len(first_steps(arguments[0], 10**6).time) == len(arguments[0].time)


def scored(loaded: LoadedSubject, case: MastCase, truth: MastMotion) -> Row:
    (row,) = score_mast(loaded, case, truth, repetitions=0)
    return row


def of_file(columns: Table, folder: Path, case: MastCase, truth: MastMotion, suffix: str = "parquet") -> Row:
    path = folder / f"mine.{suffix}"
    write_columns(columns, path)
    loaded = result_file(path, MAST_ANTENNA, [case.name])
    assert loaded.of_case is not None
    return scored(loaded.of_case(case.name, truth.interval), case, truth)


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_file_scores_as_what_it_was_written_from(
    suffix: str, table: Table, result: dict[str, Any], tmp_path: Path, case: MastCase, truth: MastMotion
) -> None:
    wrong = result | {"height": result["height"] + 3.0}
    expected = scored(LoadedSubject(Subject(f"mine.{suffix}", None, "", ""), lambda *_: wrong), case, truth)
    assert expected["status"] == "ok"
    assert (expected["nis_ratio"], expected["position_max_late"]) == (pytest.approx(16 / 15), pytest.approx(3))
    assert of_file(table | {"height": table["height"] + 3.0}, tmp_path, case, truth, suffix) == expected


def test_a_covariance_comes_back_whole(table: Table, tmp_path: Path, result: dict[str, Any]) -> None:
    path = tmp_path / "mine.arrow"
    write_columns({name: values for name, values in table.items() if name != "case"}, path)
    contract = MastContract()
    made = contract.result(path, read_columns(path, contract.outputs, ("time",)))
    np.testing.assert_array_equal(made["covariance"], result["covariance"])


def changed(column: str, second: int, value: float) -> Callable[[Table], Table]:
    return lambda table: (
        table | {column: np.where(np.arange(SECONDS + 1) == second, value, np.asarray(table[column], float))}
    )


def without(*names: str) -> Callable[[Table], Table]:
    return lambda table: {name: values for name, values in table.items() if name not in names}


def rows(*kept: int) -> Callable[[Table], Table]:
    return lambda table: {name: np.asarray(values)[list(kept)] for name, values in table.items()}


@pytest.mark.parametrize(
    ("change", "status", "message", "second"),
    [
        (changed("mu_x", 2, np.nan), "not finite", "mu holds NaN or infinity, first at t = 2 s", 2),
        (changed("covariance_3_7", 1, np.inf), "not finite", "covariance holds NaN or infinity, first at t = 1 s", 1),
        (changed("covariance_3_3", 2, -1.0), "error", "covariance is not positive, first at t = 2 s", 2),
        (changed("lambda_w", 1, 1.5), "error", "lambda is no unit quaternion, first at t = 1 s", 1),
        (without("time"), "wrong shape", "mine.parquet has no column time", None),
        (without("mu_x", "height"), "wrong shape", "mine.parquet has no column mu_x, height", None),
        (without("nis_freedom"), "wrong shape", "mine.parquet has no column nis_freedom", None),
        (
            without(*COVARIANCE[1:]),
            "wrong shape",
            "has no column covariance_1_2, covariance_1_3,",
            None,
        ),
        (rows(0, 1, 3), "wrong shape", "mine.parquet, case brief: 1 row missing of 4, the first of them time 2", None),
        (rows(0, 1, 2), "wrong shape", "1 row missing of 4, the first of them time 3", None),
        (rows(0, 1, 1, 2, 3), "wrong shape", "time 1 stands twice", None),
        (changed("time", 1, 1.004), "wrong shape", "time 1.004 is none of this case's, 0 to 3", None),
    ],
)
def test_what_is_no_result_says_why_and_since_when(
    change: Callable[[Table], Table],
    status: str,
    message: str,
    second: float | None,
    table: Table,
    tmp_path: Path,
    case: MastCase,
    truth: MastMotion,
) -> None:
    row = of_file(change(table), tmp_path, case, truth)
    assert (row["status"], row["failed_at"]) == (status, second)
    assert message in row["message"]
    # Of what is no covariance the errors are scored all the same.
    assert (row["mu_max_late"] is None) == ("covariance is not positive" not in message)


def test_a_covariance_of_a_callable_must_be_symmetric(
    result: dict[str, Any], case: MastCase, truth: MastMotion
) -> None:
    covariance = result["covariance"].copy()
    covariance[2, 1, 0] *= -1
    given = result | {"covariance": covariance}
    row = scored(LoadedSubject(Subject("mine", None, "", ""), lambda *_: given), case, truth)
    assert (row["status"], row["message"]) == ("error", "covariance is not symmetric, first at t = 2 s")


def test_a_program_that_hangs_is_stopped_and_one_without_a_table_says_what_it_needs(
    tmp_path: Path, case: MastCase, truth: MastMotion
) -> None:
    hangs, empty = tmp_path / "hangs.py", tmp_path / "empty.py"
    hangs.write_text("import time\ntime.sleep(1000)\n", encoding="utf-8")
    empty.write_text("print('roll,pitch')\n", encoding="utf-8")
    for path, limits, status, message in (
        (hangs, Limits(timeout=0.3), "timeout", "stopped after 0.3 s"),
        (empty, Limits(), "wrong shape", "names no column of mu_w, mu_x,"),
    ):
        row = scored(program(f'"{sys.executable}" -S "{path}"', MAST_ANTENNA, limits=limits), case, truth)
        assert row["status"] == status
        assert message in row["message"]
        assert len(row["message"]) < 300


def test_programs_get_all_steps() -> None:
    with pytest.raises(
        SubjectError, match="--samples-per-step 2 is for dual_precession and gyro_systems; on mast_antenna"
    ):
        program("mine", MAST_ANTENNA, samples_per_step=2)


def test_a_process_of_its_own_changes_nothing(
    arguments: tuple[MastInputs, MastStart], case: MastCase, truth: MastMotion
) -> None:
    here, there = (make(CALLABLE) for make in (resolve, isolated_subject))
    expected = scored(here, case, truth)
    assert expected["status"] == "ok"
    assert scored(there, case, truth) == expected


def test_a_twist_that_is_known_exactly_has_rounding_for_a_covariance(
    result: dict[str, Any], case: MastCase, truth: MastMotion
) -> None:
    covariance = result["covariance"].copy()
    covariance[:, 14, :] = covariance[:, :, 14] = 0
    covariance[0, 14, 2] = 1e-30
    given = result | {"covariance": covariance}
    row = scored(LoadedSubject(Subject("mine", None, "", ""), lambda *_: given), case, truth)
    assert (row["status"], row["message"]) == ("ok", None)
