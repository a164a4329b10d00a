"""Tables in place of arguments and results: what a program is given, and that not a bit is lost on the way."""

import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from sinsbench.elsewhere.contracts import contract_of
from sinsbench.elsewhere.files import FORMATS, read_columns, write_columns
from sinsbench.elsewhere.programs import program
from sinsbench.scoring.runs import inputs_of
from sinsbench.scoring.score import prepare, score
from sinsbench.subjects.loading import resolve
from sinsbench.subjects.outcome import OutcomeError
from sinsdata.tiers import paper_cases
from sinsdata.truth.conventions import CONVENTIONS
from sinsdata.truth.sampling import sample
from sinsref.exact import ExactNumber

ROOT = Path(__file__).resolve().parents[2]
TWO_SAMPLE = f"{ROOT / 'examples' / 'two_sample.py'}:two_sample"
QUATERNION = ("q_w", "q_x", "q_y", "q_z")

# Reads and writes with nothing of ours; the arithmetic is that of the example, so that not a bit may differ.
PROGRAM = f"""
import sys
import numpy as np
import pyarrow as pa
import pyarrow.csv, pyarrow.parquet
sys.path.insert(0, {str(ROOT / "examples")!r})
from two_sample import two_sample
source, target = (sys.argv[1:] + [None, None])[:2]
if source is None: table = pa.csv.read_csv(sys.stdin.buffer)
elif source.endswith(".csv"): table = pa.csv.read_csv(source)
elif source.endswith(".parquet"): table = pa.parquet.read_table(source)
else: table = pa.ipc.open_file(source).read_all()
column = lambda *names: np.column_stack([table[name].to_numpy() for name in names]).astype(float)
attitude0 = column(*(f"attitude0_{{a}}" for a in "wxyz"))[0]
q = two_sample(column("angle_x", "angle_y", "angle_z"), None, None, attitude0, None)
out = pa.table({{"more": ["?"] * len(q), "q_z": q[:, 3], "q_w": q[:, 0], "q_x": q[:, 1], "q_y": q[:, 2],
    "seconds": [1.0] * len(q)}})
if target is None: pa.csv.write_csv(out, sys.stdout.buffer)
elif target.endswith(".csv"): pa.csv.write_csv(out, target)
elif target.endswith(".parquet"): pa.parquet.write_table(out, target)
else:
    with pa.OSFile(target, "wb") as f, pa.ipc.new_file(f, out.schema) as w: w.write_table(out)
"""


@pytest.fixture(scope="module")
def short():
    case = next(case for case in paper_cases("dual_precession") if case.name == "variant2_general")
    return replace(case, duration=ExactNumber("0.64"))


@pytest.fixture(scope="module")
def inputs(short):
    """What an integrator of increments is called with."""
    return inputs_of(sample(short, Fraction(1), None, "increments"), 64)


@pytest.mark.parametrize("suffix", [*FORMATS, "pipe"])
def test_not_a_bit_is_lost_in_any_format(tmp_path, inputs, suffix):
    (tmp_path / "my program.py").write_text(PROGRAM, encoding="utf-8")
    command = f'"{sys.executable}" "{tmp_path / "my program.py"}"'
    if suffix != "pipe":
        command += " {input} {output}"
    loaded = program(command, "dual_precession", suffix="csv" if suffix == "pipe" else suffix)
    assert loaded.subject.name == "my program.py"
    made = loaded.function(*inputs).result
    assert list(made) == ["attitude"]
    np.testing.assert_array_equal(made["attitude"], resolve(TWO_SAMPLE).function(*inputs), strict=True)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(hnp.arrays(np.float64, st.integers(1, 20), elements=st.floats(allow_nan=False, allow_infinity=False)))
@pytest.mark.parametrize("suffix", FORMATS)
def test_every_number_survives(tmp_path_factory, suffix, values):
    path = tmp_path_factory.getbasetemp() / f"numbers.{suffix}"
    write_columns({"q_w": values, "sample": np.arange(len(values))}, path)
    read = read_columns(path, ("q_w",), ("sample",))
    assert read["q_w"].tobytes() == values.tobytes()
    np.testing.assert_array_equal(read["sample"], np.arange(len(values)))


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_table_of_each_convention(short, convention):
    motion = sample(short, Fraction(1), None, convention)
    arguments = inputs_of(motion, len(motion.ends) - 1)
    contract = contract_of("dual_precession", convention)
    table = contract.table(arguments, {})
    vectors = [CONVENTIONS[convention].first[1], CONVENTIONS[convention].second[1]]
    head = ["sample", "time", "interval", *(f"{stem}_{axis}" for stem in vectors for axis in "xyz")]
    assert list(table) == [*head, *(f"attitude0_{x}" for x in "wxyz"), *(f"velocity0_{x}" for x in "xyz")]
    for stem, vector in zip(vectors, arguments[:2], strict=True):
        np.testing.assert_array_equal(np.column_stack([table[f"{stem}_{axis}"] for axis in "xyz"]), vector)
    rows = len(arguments[0])
    ends = motion.end_times[-rows:]
    np.testing.assert_allclose(table["time"], ends, rtol=1e-15, atol=0)  # a product of two binary64
    np.testing.assert_array_equal(contract.epochs(arguments)[-rows:], table["time"])
    assert len(contract.epochs(arguments)) == len(motion.end_times)
    np.testing.assert_array_equal(table["attitude0_w"], np.full(rows, motion.attitude[0, 0]))
    # One step of two samples.
    steps = (len(motion.ends) - 1) // 2
    beginning, part = contract.shortest(arguments, steps + 1)
    assert len(contract.epochs(beginning)) == 3
    assert part == 1 - 1 / steps


SOLVER = f"""
import sys
import pandas as pd
sys.path.insert(0, {str(ROOT / "examples")!r})
from solver import exponential
names = ["dv_north", "dv_up", "dv_east", "d_height", "d_latitude", "d_longitude"]
table = pd.read_csv(sys.argv[1], float_precision="round_trip")
first = table.iloc[0]
states = exponential(table["time"].to_numpy(), first.v_east, first.height, first[[f"{{n}}0" for n in names]].to_numpy())
pd.DataFrame(states, columns=names).assign(seconds=1.0).to_csv(sys.argv[2], index=False, float_format="%.17g")
"""


def test_a_solver_of_the_error_equations(tmp_path):
    case = replace(paper_cases("equator_errors")[0], duration=ExactNumber(600))
    (tmp_path / "prog.py").write_text(SOLVER, encoding="utf-8")
    made = program(f'"{sys.executable}" "{tmp_path / "prog.py"}" {{input}} {{output}}', "equator_errors")
    theirs, ours = score([made, f"{ROOT / 'examples' / 'solver.py'}:exponential"], [case])
    assert theirs["status"] == ours["status"] == "ok"
    same = [name for name in theirs if name.startswith("error_") or name in ("scd", "ulp_max")]
    assert {name: theirs[name] for name in same} == {name: ours[name] for name in same}


def test_a_solver_is_told_of_a_misalignment():
    matrix = tuple(tuple(ExactNumber(3 * i + j) for j in (1, 2, 3)) for i in (0, 1, 2))
    case = replace(paper_cases("equator_errors")[0], misalignment=matrix, inertial_longitude=ExactNumber("0.5"))
    reference = prepare(replace(case, duration=case.interval))
    table = contract_of("equator_errors", "").table(reference.arguments, reference.keywords)
    given = [[table[f"misalignment_{i}{j}"][0] for j in (1, 2, 3)] for i in (1, 2, 3)]
    assert given == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert table["inertial_longitude"][-1] == 0.5
    assert list(table)[:4] == ["time", "v_east", "height", "dv_north0"]


@pytest.mark.parametrize("suffix", ["parquet", "arrow"])
def test_files_that_are_no_tables(tmp_path, suffix):
    path = tmp_path / f"output.{suffix}"

    def refusal():
        with pytest.raises(OutcomeError) as caught:
            read_columns(path, QUATERNION)
        return caught.value.status, str(caught.value)

    assert refusal() == ("error", f"there is no file output.{suffix}")
    path.write_bytes(b"garbage")
    assert refusal()[0] == "wrong shape"
    assert f"output.{suffix} is no {suffix} file: " in refusal()[1]
    for column, message in (
        (pa.array([1.0, None]), f"output.{suffix}, row 1, column q_w holds nothing"),
        (pa.array(["a", "b"]), f"output.{suffix}, column q_w holds string, not numbers"),
        (pa.array([[1.0], [2.0]]), f"output.{suffix}, column q_w holds list<"),
    ):
        table = pa.table({"q_w": column})
        if suffix == "parquet":
            pq.write_table(table, path)
        else:
            with pa.OSFile(str(path), "wb") as file, pa.ipc.new_file(file, table.schema) as writer:
                writer.write_table(table)
        assert message in refusal()[1]
