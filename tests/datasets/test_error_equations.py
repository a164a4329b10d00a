"""The dataset `error_equations`: cases, certified rows, the second path, the tiers."""

from __future__ import annotations

from itertools import pairwise
from math import log10
from typing import Any

import numpy as np
import pytest

from sinsdata.cases import CaseError, ErrorEquationCase
from sinsdata.tiers.error_equations import (
    ERROR_EQUATION_STRATA,
    error_equation_paper_cases,
    error_equation_standard_cases,
)
from sinsdata.truth import error_equations as error_equation_truth
from sinsdata.truth.certified import Block
from sinsdata.truth.error_equations import error_equation_blocks, recomputed_rows
from sinsref.rounding import RoundingTally, UndecidedError

GIVEN: dict[str, Any] = {
    "name": "case",
    "motion": "great_circle",
    "latitude": "pi/4",
    "longitude": 0.5,
    "height": 5000.0,
    "speed": 250,
    "heading": "pi/3",
    "duration": 120,
    "interval": "40",
    "initial_errors": [0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7],
}
TURN: dict[str, Any] = {"motion": "climbing_turn", "climb_rate": "10", "turn_rate": "pi/240"}
#: Keys that make another motion of `GIVEN`.
MOTIONS: dict[str, dict[str, Any]] = {
    "parallel": {"motion": "parallel", "heading": None},
    "meridian": {"motion": "meridian", "heading": None, "speed": -250},
    "great_circle": {},
    "climbing_turn": TURN,
}


def case(**changes: Any) -> ErrorEquationCase:
    given = {**GIVEN, **changes}
    return ErrorEquationCase.from_mapping({key: value for key, value in given.items() if value is not None})


def rows(of: ErrorEquationCase, first: int = 0, number: int | None = None) -> tuple[Block, RoundingTally]:
    """Return some rows of a case, all by default, as one block."""
    tally = RoundingTally()
    blocks = list(error_equation_blocks(of, first, of.samples + 1 - first if number is None else number, tally))
    parts = [np.concatenate([getattr(block, name) for block in blocks]) for name in Block.__dataclass_fields__]
    return Block(*parts), tally


@pytest.mark.parametrize("motion", MOTIONS)
def test_rows_agree_with_the_second_path(motion: str) -> None:
    """Relative 1e-30 of the value, which the pair promises; 1e-50 of the row's largest where the value is 0."""
    of = case(**MOTIONS[motion])
    block, tally = rows(of)
    assert tally.values == block.high.size + len(block.index)
    for row, (time, *values) in enumerate(recomputed_rows(of, range(4))):
        assert float(time) == block.time[row] == 40.0 * row
        for value, high, low in zip(values, block.high[row], block.low[row], strict=True):
            assert abs(value - high - low) <= 1e-30 * abs(value) + 1e-50 * 5000


def test_the_second_path_gives_the_same_rows_whichever_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Several epochs in a step, one that is not reached at once, and steps of another length: to 45 digits."""
    of = case(**TURN, duration=24, interval="4")
    every = list(recomputed_rows(of, range(7)))
    assert list(recomputed_rows(of, [0, 3, 6])) == [every[0], every[3], every[6]]
    assert list(recomputed_rows(of, [])) == []
    monkeypatch.setattr(error_equation_truth, "_plain_step", lambda _: 6.0)
    (finer,) = recomputed_rows(of, [6])
    for x, y in zip(finer, every[6], strict=True):
        assert abs(x - y) <= 1e-45 * abs(x) + 1e-55 * 5000


def test_columns_are_motion_truth_nonlinear_and_linearisation() -> None:
    block, _ = rows(case(**TURN))
    assert block.high.shape == (4, 27)
    start = [float(x) for x in case().initial_errors]
    assert block.high[0, 9:15].tolist() == block.high[0, 15:21].tolist() == start
    assert not block.high[0, 21:].any()
    assert not block.low[0, 21:].any()
    # nonlinear = linear + linearisation, in pairs: a few roundings of the rests, 2^-53 of each.
    linear, nonlinear, rest = (block.high[:, at : at + 6] for at in (9, 15, 21))
    rests = block.low[:, 15:21] - block.low[:, 9:15] - block.low[:, 21:]
    assert np.all(np.abs((nonlinear - linear) - rest + rests) <= 1e-15 * np.abs(rest) + 1e-31 * np.abs(linear))
    assert np.all(block.high[:, 1] == 10)
    assert np.all(np.diff(block.high[:, 3]) > 400)  # it climbs 10 m/s for 40 s, over 1 / alpha > 1
    assert np.all(np.abs(block.high[:, 7] - 9.8) < 0.1)


def test_what_is_exactly_zero_is_stored_as_zero() -> None:
    parallel, tally = rows(case(**MOTIONS["parallel"]))
    assert not parallel.high[:, [0, 1, 8]].any()  # v_N, v_H, force east
    # They are counted, with the error of the linear theory at the start.
    assert tally.exact_zeros == 3 * 4 + 6 == (parallel.high == 0).sum()
    meridian, _ = rows(case(**MOTIONS["meridian"]))
    assert not meridian.high[:, [1, 2]].any()
    assert np.all(meridian.high[:, 5] == 0.5)
    # On the equator north speed and latitude are a system of their own: errors of height and longitude leave it alone.
    equator, _ = rows(case(**MOTIONS["parallel"], latitude=0, initial_errors=[0, "0.01", 0, 1, 0, "1e-7"]))
    for columns in (0, 4, 6, 9, 13, 15, 19, 21, 25):
        assert not equator.high[:, columns].any()


def test_a_velocity_that_passes_through_zero_on_an_epoch_is_zero_there() -> None:
    """Heading pi/3 + k pi/6: due east at k = 1, due south at k = 4; no ball alone tells 0 from nearly 0."""
    block, tally = rows(case(**TURN, duration=160))
    assert block.high[1, 0] == block.high[4, 2] == 0
    assert block.high[1, 2] == -block.high[4, 0] == 250
    assert tally.raised == 2
    assert (tally.exact_zeros, tally.bounded_zeros) == (2 + 6, 0)


def test_a_part_of_the_rows_is_the_part_of_all_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    of = case(interval="10")
    whole, _ = rows(of)
    part, _ = rows(of, 3, 6)
    monkeypatch.setattr(error_equation_truth, "BLOCK", 4)
    in_blocks, _ = rows(of)
    for name in Block.__dataclass_fields__:
        assert np.array_equal(getattr(part, name), getattr(whole, name)[3:9])
        assert np.array_equal(getattr(in_blocks, name), getattr(whole, name))


def test_rows_do_not_depend_on_the_working_precision(monkeypatch: pytest.MonkeyPatch) -> None:
    """With fewer bits balls leave values undecided; raising the precision gives what enough bits give at once."""
    enough, tally = rows(case())
    assert tally.raised == 0
    monkeypatch.setattr(error_equation_truth, "WORKING_BITS", 150)
    raised, tally_raised = rows(case())
    assert tally_raised.raised > 0
    assert tally_raised.exact_zeros == tally.exact_zeros
    assert np.array_equal(raised.high, enough.high)
    assert np.array_equal(raised.low, enough.low)
    monkeypatch.setattr(error_equation_truth, "ESCALATION", (1,))
    with pytest.raises(UndecidedError, match="case case, epoch 1, column"):
        rows(case())


def test_the_error_of_the_linear_theory_grows_with_the_square_of_the_errors() -> None:
    """Errors of 1e-10 and of 1: eleven decades below and above, all of them certified."""
    sizes = [1e-10, 1e-5, 1.0]
    ends = []
    for size in sizes:
        errors = [f"{x}*{size!r}" for x in ("0.01", "0.01", "0.01", "1", "1.57e-7", "1.57e-7")]
        block, _ = rows(case(initial_errors=errors))
        ends.append(np.abs(block.high[-1, 21:]))
    for (small, large), (low, high) in zip(pairwise(sizes), pairwise(ends), strict=True):
        # Cubic terms add 1e-6 of the errors, relatively; times the growth of two minutes.
        assert np.all(np.abs(high / low / (large / small) ** 2 - 1) < 1e-3)


#: Inadmissible changes, and what the message says.
REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"motion": "loop"}, "motion = 'loop': must be one of parallel, meridian, great_circle, climbing_turn"),
    ({"motion": 3}, "motion = 3: must be one of"),
    ({"heading": None}, "heading = None: the motion 'great_circle' needs it"),
    ({"turn_rate": 0.1}, "turn_rate = 0.1: the motion 'great_circle' has no such key"),
    ({"motion": "parallel"}, "heading = 'pi/3': the motion 'parallel' has no such key"),
    ({**TURN, "climb_rate": None}, "climb_rate = None: the motion 'climbing_turn' needs it"),
    ({"speed": 2500}, "speed = 2500: must be at most 2000 in magnitude"),
    ({**TURN, "climb_rate": -301}, "climb_rate = -301: must be at most 300"),
    ({**TURN, "turn_rate": "0.5"}, "turn_rate = 0.5: must be at most 0.4"),
    ({"height": -20000}, "height = -20000: the height must stay between -10000 and 1e\\+06 m"),
    ({**TURN, "climb_rate": -200}, "climb_rate = -200: the height must stay between"),
    ({"latitude": "pi/2 - 0.004"}, "latitude = pi/2 - 0.004: the motion may come within 0.001 rad of a pole"),
    ({"latitude": -1.57}, "latitude = .*: the motion may come within 0.001 rad of a pole"),
    ({"initial_errors": [0] * 6}, "initial_errors = .*must not all be 0"),
    ({"initial_errors": [0, 0, 0, 0, 0.3, 0]}, "initial_errors = .*must be below 0.2 of the Earth's radius"),
    ({"initial_errors": [1, 2]}, "initial_errors = .*must have 6 elements, not 2"),
    ({"duration": 8000}, "duration = 8000: the errors may grow beyond 0.2 of the Earth's radius; at most 6"),
    ({"interval": "50"}, "duration = 120: must be a whole number of intervals"),
    ({"altitude": 3}, "altitude = 3: unknown key; did you mean 'latitude'"),
    ({"latitude": "north"}, "latitude = 'north'"),
]


@pytest.mark.parametrize(("changes", "message"), REFUSED, ids=range(len(REFUSED)))
def test_an_inadmissible_case_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError, match=message):
        case(**changes)


def test_a_parallel_may_run_as_near_to_the_pole_as_stated() -> None:
    near = {"motion": "parallel", "heading": None, "speed": 1, "initial_errors": ["1e-9"] * 6}
    assert case(**near, latitude="pi/2 - 0.00101").pole_clearance > 1e-3
    with pytest.raises(CaseError, match=r"within 0\.001 rad"):
        case(**near, latitude="pi/2 - 0.00099")


def test_the_paper_tier_has_the_vehicles_and_errors_of_the_paper() -> None:
    cases = error_equation_paper_cases()
    assert [x.name for x in cases] == [
        f"{vehicle}_{motion}" for vehicle in ("fighter", "ship") for motion in MOTIONS
    ]  # fmt: skip
    for x in cases:
        place = ("600", "10000") if x.name.startswith("fighter") else ("10", "0")
        assert (x.speed.text, x.height.text) == place
        assert (x.latitude.text, x.duration.text, x.interval.text) == ("pi/4", "3600", "60")
        assert [e.text for e in x.initial_errors] == ["0.01", "0.01", "0.01", "1", "1.57e-7", "1.57e-7"]


def test_the_standard_tier_covers_its_strata() -> None:
    pairs = error_equation_standard_cases()
    assert pairs == error_equation_standard_cases()
    assert len({x.name for x, _ in pairs}) == len(pairs)
    assert {stratum for _, stratum in pairs} == set(ERROR_EQUATION_STRATA)
    of = {name: [x for x, stratum in pairs if stratum == name] for name in ERROR_EQUATION_STRATA}
    assert min(x.pole_clearance for x in of["near_pole"]) < 0.01
    assert all(abs(float(x.speed)) >= 1000 for x in of["fast"])
    assert all(5 <= abs(float(x.speed) * float(x.turn_rate or 0)) <= 15 for x in of["sharp_turn"])
    assert {x.motion for x, _ in pairs} == set(MOTIONS)
    sizes = [x.error_size for x in of["error_size"]]
    assert log10(max(sizes) / min(sizes)) == pytest.approx(11)
