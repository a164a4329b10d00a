"""The dataset `gyro_systems`: cases, certified rows, the second path, arrays for subjects, the tiers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from sinsdata.cases import CaseError, GyroCase
from sinsdata.cases.gyroscopic import first_failure
from sinsdata.format.schema import DATASETS
from sinsdata.generation.generate import generate
from sinsdata.generation.tables import GROUPS, Segment
from sinsdata.tiers import cases_from_toml, cases_of, strata_of, stratum_name
from sinsdata.tiers.gyroscopic import GYRO_STRATA, gyro_paper_cases, gyro_standard_cases
from sinsdata.truth import gyroscopic
from sinsdata.truth.certified import Block
from sinsdata.truth.gyroscopic import reference_blocks, sampled, sensor_blocks, truth_blocks
from sinsdata.truth.gyroscopic_recomputed import exact_reference, exact_sensors, exact_truth
from sinsdata.verification.gyroscopic_invariants import INVARIANTS
from sinsdata.verification.stored_rows import Stretch, Window
from sinsdata.verification.verify import verify
from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.rounding import RoundingTally, UndecidedError

TRACK = {
    "name": "track",
    "motion": "track",
    "latitude": "0.9 + 1e-3*sin(2*pi*t/300)",
    "longitude": "0.5 + 1e-4*t",
    "duration": "40",
    "interval": "4",
}
CIRCLE = {
    "name": "circle",
    "motion": "great_circle",
    "latitude": "pi/4",
    "longitude": "1",
    "course": "pi/3",
    "speed": "300 + 100*sin(t/50)",
    "altitude": "10*t",
    "duration": "40",
    "interval": "4",
}
PARALLEL = {**TRACK, "name": "parallel", "motion": "parallel", "latitude": "0.3", "longitude": "1", "speed": "-200"}
BLOCKS = {"sensors": sensor_blocks, "truth": truth_blocks, "reference": reference_blocks}
EXACT = {"sensors": exact_sensors, "truth": exact_truth, "reference": exact_reference}
Blocks = Callable[[GyroCase, int, int, RoundingTally], Iterator[Block]]


def case(**given: Any) -> GyroCase:
    return GyroCase.from_mapping({**TRACK, **given})


def rows(made: GyroCase, table: str, first: int = 0, count: int | None = None) -> tuple[Block, RoundingTally]:
    tally = RoundingTally()
    blocks = list(BLOCKS[table](made, first, made.samples + 1 - first if count is None else count, tally))
    return Block(*(np.concatenate([getattr(block, field.name) for block in blocks]) for field in fields(Block))), tally


def same(a: Block, b: Block) -> bool:
    return all(np.array_equal(getattr(a, field.name), getattr(b, field.name)) for field in fields(Block))


@pytest.mark.parametrize("table", BLOCKS)
@pytest.mark.parametrize("given", [TRACK, CIRCLE, PARALLEL], ids=lambda given: given["name"])
def test_certified_rows_are_those_of_the_second_path(table: str, given: dict[str, Any]) -> None:
    """mpmath, derivatives by definition and plain integration: 1e-30 of each value that the pair holds."""
    made, ar = GyroCase.from_mapping(given), MpArithmetic(60)
    block, tally = rows(made, table)
    assert tally.values == block.high.size + len(block.time)
    wanted = (0, 1, 4)
    for row, (time, *values) in zip(wanted, EXACT[table](made, wanted), strict=True):
        assert float(time) == block.time[row]
        # What mpmath leaves of an exact zero.
        smallest = max(map(abs, values)) * ar.context.mpf("1e-50")
        for value, high, low in zip(values, block.high[row], block.low[row], strict=True):
            difference = abs(value - ar.context.mpf(float(high)) - ar.context.mpf(float(low)))
            assert difference <= max(abs(value) * ar.context.mpf("1e-30"), smallest)


@pytest.mark.parametrize("table", BLOCKS)
def test_rows_do_not_depend_on_segments_and_blocks(table: str, monkeypatch: pytest.MonkeyPatch) -> None:
    made = GyroCase.from_mapping(CIRCLE)
    whole, _ = rows(made, table)
    part, _ = rows(made, table, 3, 5)
    monkeypatch.setattr(gyroscopic, "BLOCK", 4)
    assert same(rows(made, table)[0], whole)
    assert same(part, Block(*(getattr(whole, field.name)[3:8] for field in fields(Block))))


@pytest.mark.parametrize("table", ["sensors", "reference"])
def test_rows_do_not_depend_on_the_working_precision(table: str, monkeypatch: pytest.MonkeyPatch) -> None:
    made = case()
    enough, tally = rows(made, table)
    assert tally.raised == 0
    monkeypatch.setattr(gyroscopic, "WORKING_BITS", 110)
    raised, tally_raised = rows(made, table)
    assert tally_raised.raised > 0
    assert same(raised, enough)
    monkeypatch.setattr(gyroscopic, "ESCALATION", (1,))
    with pytest.raises(UndecidedError, match="case track, epoch"):
        rows(made, table)


def test_what_cancels_is_a_bounded_zero() -> None:
    """A level vehicle along a parallel does not turn about its forward axis: a right angle leaves 1e-300 of it."""
    level = GyroCase.from_mapping({**PARALLEL, "heading": "pi/2", "pitch": 0, "roll": 0, "duration": "8"})
    block, tally = rows(level, "sensors")
    assert tally.bounded_zeros > 0
    assert not block.high[:, 1].any()
    assert block.high[:, 0].all()


def test_arrays_for_subjects_on_the_whole_and_the_half_grid() -> None:
    made = GyroCase.from_mapping(CIRCLE)
    whole, half = sampled(made), sampled(made, Fraction(1, 2))
    assert (whole.case_name, whole.interval, half.interval) == ("circle", 4.0, 2.0)
    assert whole.rate.shape == (11, 3)
    assert whole.angle_increment.shape == whole.velocity_increment.shape == (10, 3)
    assert whole.trihedron.shape == whole.attitude.shape == (11, 4)
    assert whole.latitude.shape == whole.speed_lo.shape == (11,)
    for field in fields(whole):
        value = getattr(half, field.name)
        if isinstance(value, np.ndarray) and "increment" not in field.name:
            assert np.array_equal(value[::2], getattr(whole, field.name)), field.name
    pairs = half.velocity_increment.reshape(10, 2, 3).sum(axis=1)
    assert np.allclose(pairs, whole.velocity_increment, rtol=0, atol=1e-14)  # one rounding of 40 m/s
    with pytest.raises(CaseError, match="does not divide 40 s into whole samples"):
        sampled(made, 3)


#: Inadmissible changes, and what the message says.
REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"motion": "loop"}, "motion = 'loop': must be one of track, parallel, great_circle"),
    ({"speed": 3}, "speed = 3: the motion 'track' has no such key"),
    ({"motion": "parallel"}, "speed = None: the motion 'parallel' needs it"),
    ({"motion": "great_circle", "speed": 300}, "course = None: the motion 'great_circle' needs it"),
    ({"motion": "parallel", "speed": 9}, "latitude = 0.9 .*: must be a constant on a parallel"),
    ({"latitude": "1/t"}, "latitude = '1/t': a function of time cannot be a divisor"),
    ({"latitude": True}, "latitude = True: must be a number, or a string"),
    ({"heading": "1e40"}, "heading = .*must be 0, or 1e-30 to 1e"),
    ({"radius": -1}, "radius = -1: must be greater than 0 m"),
    ({"gravity": 0}, "gravity = 0: must be greater than 0 m/s"),
    ({"interval": "7"}, "duration = 40: must be a whole number of intervals"),
    ({"latitude": "1.5 + 0.01*t"}, r"latitude = 1.5 \+ 0.01\*t: the motion comes within 0.001 rad of a pole; t = 6.97"),
    ({"pitch": "0.1*t"}, r"pitch = 0.1\*t: comes within 0.001 rad of a right angle; t = 15.69"),
    ({"latitude": "0.5", "longitude": "0.1 - 7.292115e-5*t"}, "latitude = 0.5: the absolute speed falls below 0.001"),
    ({"rotation_rate": 0, "longitude": "1e-6*(t - 20)*(t - 20)", "latitude": "0.5"}, "falls below 0.001 m/s; t = 19.9"),
    ({"longitude": "1e-4*t*t"}, r"the absolute speed reaches sqrt\(gravity\*radius\); t = 9."),
    ({"altitude": "1e4*t*t"}, r"altitude = 1e4\*t\*t: must stay between -10000 and 1e\+06 m; t = 10"),
    ({"altitude": "-1e3*t"}, r"altitude = -1e3\*t: must stay between -10000 and 1e\+06 m; t = 10"),
    ({"altitude_": 1}, "altitude_ = 1: unknown key; did you mean 'altitude'"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "message"), REFUSED, ids=range(len(REFUSED)))
def test_an_inadmissible_case_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError, match=message):
        case(**changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"latitude": 1.6}, r"latitude = 1\.6.*: must lie between -pi/2 and pi/2; t = 0 s"),
        ({"pitch": "2*pi"}, r"pitch = 2\*pi: must lie between -pi/2 and pi/2; t = 0 s"),
        (
            {"duration": 1e9, "interval": 1e6, "speed": 300, "altitude": 0},
            "duration = 1000000000: is too long to decide that the latitude is admissible at all times; t = 1.6",
        ),
        ({"speed": "10*cos(t)"}, r"speed = 10\*cos\(t\): must be greater than 0 m/s; t = 1.57"),
        ({"speed": 7906}, "speed = 7906: the absolute speed reaches"),
        ({"course": 0, "latitude": "pi/2 - 0.0015"}, "latitude = .*within 0.001 rad of a pole; t = 1"),
        ({"latitude": "t"}, "latitude = t: must be a constant on a great_circle"),
    ],
)
def test_an_inadmissible_great_circle_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError, match=message):
        GyroCase.from_mapping({**CIRCLE, **changes})


def test_a_limit_of_the_speed_is_checked_at_all_times() -> None:
    """What a two-rotor frame needs: 300 + 100 sin(t/50) is 371.7 m/s after 40 s, at altitude 0.006 % more."""
    circle = GyroCase.from_mapping(CIRCLE)
    circle.check_speed_below(372)
    with pytest.raises(CaseError, match=r"absolute speed must stay below 350 m/s; t = 26\.1"):
        circle.check_speed_below(350)


def test_an_instant_between_the_epochs_is_found() -> None:
    """A function that is positive but for a microsecond."""
    with BallArithmetic(64) as ar:
        assert first_failure(lambda t: (t - ar.number("12.3")) ** 2 - 1e-12, ar.number(40)) == pytest.approx(12.3)
        assert first_failure(lambda t: (t - ar.number("12.3")) ** 2 + 1e-6, ar.number(40)) is None


def window(made: GyroCase) -> Window:
    """Return the rows of a case as the verification reads them."""
    tables = {}
    for group in GROUPS["gyro_systems"][1:]:
        ((batch,),) = group.batches("sweep", [Segment(made, 0, made.samples + 1)], RoundingTally())
        tables[group.tables[0]] = batch
    return Window((Stretch(made, 0, made.samples),), tables)


def excess(seen: Window) -> dict[str, float]:
    return {
        invariant.name: max(float(residual.excess.max()) for residual in invariant.residuals(seen))
        for invariant in INVARIANTS
    }


@pytest.mark.parametrize("given", [TRACK, CIRCLE, PARALLEL], ids=lambda given: given["name"])
def test_the_relations_between_rows_hold(given: dict[str, Any]) -> None:
    assert max(excess(window(GyroCase.from_mapping(given))).values()) <= 1


@pytest.mark.parametrize(
    ("table", "column", "row", "relation"),
    [
        ("truth", "q_x", 5, "unit quaternions"),
        ("truth", "vertical_y", 5, "vertical and velocity"),
        ("truth", "velocity_z", 5, "vertical and velocity"),
        ("truth", "trihedron_z", 5, "vertical and velocity"),
        ("truth", "longitude", 5, "longitudes"),
        ("truth", "pitch", 0, "start of the motion"),
        ("sensors", "angle_z", 0, "start of the motion"),
        ("reference", "rest_mirror_x", 5, "unit axes"),
        ("reference", "paper_gyro_y", 5, "keep their angle"),
        ("reference", "paper_bisector_x", 5, "half way"),
    ],
)
def test_a_changed_value_breaks_a_relation(table: str, column: str, row: int, relation: str) -> None:
    seen = window(case())
    batch = seen.tables[table]
    values = np.array(batch[f"{column}_lo"])
    values[row] += 1e-25
    columns = [pa.array(values) if name == f"{column}_lo" else batch[name] for name in batch.schema.names]
    changed = Window(seen.parts, {**seen.tables, table: pa.RecordBatch.from_arrays(columns, schema=batch.schema)})
    broken = [name for name, size in excess(changed).items() if size > 1]
    assert any(relation in name for name in broken)


def test_cases_from_a_file_generate_and_verify(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(
        """
        [[case]]
        name = "mine"
        motion = "great_circle"
        latitude = 0.25
        longitude = "pi/6"
        course = "pi/3"
        speed = "300 + 100*sin(2*pi*t/1800)"
        pitch = 0
        duration = 4
        interval = 2
        """
    )
    (mine,) = cases_from_toml("gyro_systems", tmp_path / "my.toml")
    assert isinstance(mine, GyroCase)
    assert (mine.latitude.text, mine.pitch.text) == ("0.25", "0")
    folder = generate("gyro_systems", "sweep", (mine,), tmp_path).folder
    checks = list(verify(folder))
    assert [check for check in checks if not check.holds] == []
    assert sum("computed again by mpmath" in check.what for check in checks) == 3


def test_the_paper_tier_has_the_motions_of_the_claims() -> None:
    cases = {made.name: made for made in gyro_paper_cases()}
    assert list(cases)[:7] == ["T0", "T1", "T2", "T3", "T4", "T5", "T3_altitude"]
    assert {made.motion for made in cases.values()} == {"track", "parallel", "great_circle"}
    for name in ("T0", "T1", "T2", "T3", "T4"):
        assert (cases[name].duration.text, cases[name].interval.text) == ("7200", "1")
    assert [name for name in cases if name.startswith("TE")] == ["TE_1", "TE_0.5", "TE_0.25", "TE_0.125"]


#: Name, speed at time 0: as printed with the claims.
SPEEDS = {"T0": 266.472511703, "T1": 300.0, "T2": 516.472511703, "T3": 644.295202574, "T4": 300.0, "TP_1": 600.0,
          "TP_0.125": 75.0}  # fmt: skip


@pytest.mark.parametrize("name", SPEEDS)
def test_the_cases_have_the_speeds_of_the_claims(name: str) -> None:
    (made,) = (x for x in gyro_paper_cases() if x.name == name)
    block, _ = rows(made, "truth", 0, 1)
    assert block.high[0, 5] == pytest.approx(SPEEDS[name], abs=5e-10)


def test_the_near_stop_is_near_a_stop() -> None:
    (made,) = (x for x in gyro_paper_cases() if x.name == "T5")
    block, _ = rows(made, "truth", 1799, 3)
    assert block.high[1, 5] == pytest.approx(0.05, rel=1e-12)
    assert block.high[0, 5] == pytest.approx((0.05**2 + 0.2**2 * np.cos(np.pi / 180) ** 2) ** 0.5, rel=1e-9)


def test_the_standard_tier_covers_its_strata() -> None:
    pairs = gyro_standard_cases()
    assert len({made.name for made, _ in pairs}) == len(pairs)
    assert {stratum for _, stratum in pairs} == set(GYRO_STRATA)
    assert sum(count for _, count, _ in strata_of("gyro_systems")) == len(pairs)
    assert all(stratum_name("gyro_systems", made.name) == stratum for made, stratum in pairs)
    assert {made.name for made in cases_of("gyro_systems", "short")} <= {made.name for made, _ in pairs}


def test_the_columns_stand_as_the_blocks_fill_them() -> None:
    made = case()
    for table, width in (("sensors", 12), ("truth", 23), ("reference", 18)):
        pairs = [column for column in DATASETS["gyro_systems"].tables[table] if column.kind == "pair"]
        assert len(pairs) == width + 1  # and the time
        assert rows(made, table, 0, 2)[0].high.shape == (2, width)
