"""Every row of a dataset against the differential equations themselves: the path that knows no closed form.

Taylor series of the equations are summed at all epochs that a step reaches. Their coefficients are numbers of 62 digits
without enclosures (the radii of the balls are dropped after every step): this path compares, it proves nothing. What it
shares with the tables are the equations, their constants and the initial values, no solution. The tables of
`error_equations` have no closed form: their second path, Taylor series in mpmath, is this integration. Those of
`mast_antenna` hold values of a stated accuracy: errors are told in units of it.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from fractions import Fraction
from math import floor, frexp, hypot, inf, ldexp
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import numpy as np
import pyarrow as pa
from flint import arb, arb_poly, fmpq

from sinsdata.cases import CASE_CLASSES, Case, DualPrecessionCase, EquatorCase, ErrorEquationCase, GyroCase, MastCase
from sinsdata.format.manifest import DatasetError, read_manifest, table_files
from sinsdata.generation.tables import GROUPS, groups_of
from sinsdata.generation.workers import follow_parent
from sinsdata.truth.formulas import TRANSITION_ELEMENTS
from sinsdata.verification.gyroscopic_problem import VECTORS, GyroscopicProblem
from sinsdata.verification.mast_problem import PER_EPOCH, PER_STEP, MastProblem
from sinsdata.verification.recompute import (
    PAIR_TOLERANCE,
    Worst,
    computed_columns,
    largest_errors,
    pair_columns,
    row_errors,
)
from sinsdata.verification.stored_cases import load_cases
from sinsdata.verification.stored_rows import TableLayout
from sinsdata.verification.stored_values import pair_rows, slices, value_rows
from sinsdata.verification.verify import Check
from sinsref.arithmetic import Arithmetic, BallArithmetic, Number
from sinsref.equator import EquatorModel
from sinsref.equator_forced import Misalignment
from sinsref.error_equations import Earth, error_matrix, required_force
from sinsref.precession import angular_rate_and_specific_force
from sinsref.quaternion import conjugate, dot, normalised, product, rotate
from sinsref.recorded import AutonomousField, RecordedField

#: Working precision: 30 digits to compare, and what a day of steps adds up.
_BITS = 208
#: Order of the series. The last terms of a step are at most exp(-105) = 2.5e-46 of the largest.
_ORDER, _LOG_TAIL, _LAST = 48, -105.0, 4
#: The same where values of binary64 are compared: 1e-26.
_VALUE_TAIL = -60.0
#: Rows that stand near a zero of what they hold are compared on the scale of what was before, this much smaller.
_NEAR_ZERO = 1e-8

#: Table -> the values of a row.
Values: TypeAlias = Mapping[str, Sequence[Number]]
#: Table -> its files, and the number in them of the first row of a case.
Stored: TypeAlias = Mapping[str, tuple[Sequence[Path], int]]


class Equations(Protocol):
    """What `states` integrates: see `Problem`."""

    @property
    def field(self) -> AutonomousField:
        """The derivative of a state."""

    @property
    def initial(self) -> Sequence[Number]:
        """The state at the start."""


@dataclass(frozen=True)
class Problem:
    """An initial value problem whose solution fills tables.

    Attributes
    ----------
    field : callable
        ``field(arithmetic, state)``; the first component is the time.
    initial : sequence of Number
    values : callable
        ``values(state, before)`` returns the rows of an epoch; `before` is the state at the epoch before.
    vectors : mapping of str to sequence of int
        Numbers of components of the vectors in the columns of each table: a vector is compared by its norm.
    """

    field: AutonomousField
    initial: Sequence[Number]
    values: Callable[[Sequence[Number], Sequence[Number]], Values]
    vectors: Mapping[str, Sequence[int]]


def precession_problem(ar: BallArithmetic, case: DualPrecessionCase) -> Problem:
    """Return attitude, apparent velocity and the integrals of their rates: (1.1), (1.2), with (4.1), (4.3)."""
    zero = ar.number(0)
    if case.initial_attitude is None:
        sine, cosine = ar.sin_cos(ar.number(case.nutation) / 2)
        attitude = [cosine, sine, zero, zero]
    else:
        attitude = normalised(ar, [ar.number(x) for x in case.initial_attitude])
    interval = ar.number(case.interval)

    def field(arithmetic: Arithmetic, state: Sequence[Number]) -> list[Number]:
        rate, force = angular_rate_and_specific_force(arithmetic, case.motion, state[0])
        turning = [x / 2 for x in product(state[1:5], [arithmetic.number(0), *rate])]
        return [arithmetic.number(1), *turning, *rotate(state[1:5], force), *rate, *force]

    def values(state: Sequence[Number], before: Sequence[Number]) -> Values:
        unit, velocity, integrals = state[1:5], state[5:8], state[8:]
        increments = [x - y for x, y in zip(integrals, before[8:], strict=True)]
        change = [x - y for x, y in zip(velocity, before[5:8], strict=True)]
        return {
            "truth": [*unit, *velocity, *rotate(conjugate(unit), velocity)],
            "increments": increments,
            "mean_rates": [x / interval for x in increments],
            "accumulated": integrals,
            "resolved": [*rotate(conjugate(before[1:5]), change), *rotate(conjugate(unit), change)],
        }

    initial = [zero, *attitude, *map(ar.number, case.initial_velocity), *[zero] * 6]
    pairs = dict.fromkeys(("increments", "mean_rates", "accumulated", "resolved"), (3, 3))
    return Problem(field, initial, values, {"truth": (4, 3, 3), **pairs})


def equator_problem(ar: BallArithmetic, case: EquatorCase) -> Problem:
    """Return the errors and the transition matrix: X' = A X + b with A of (2) for flight along the equator."""
    zero, one = ar.number(0), ar.number(1)

    def field(arithmetic: Arithmetic, state: Sequence[Number]) -> list[Number]:
        earth = Earth.krasovsky(arithmetic, spherical=True)
        flight = [zero, zero, ar.number(case.v_east), ar.number(case.height), zero, zero]
        matrix = error_matrix(arithmetic, earth, flight, required_force(arithmetic, earth, flight, [zero] * 3))
        forcing = [zero] * 6
        if case.misalignment is not None:
            elements = [[ar.number(x) for x in row] for row in case.misalignment]
            tilt = Misalignment(elements, ar.number(case.inertial_longitude))
            forcing = tilt.force(arithmetic, EquatorModel.at(arithmetic, case.v_east, case.height), state[0])
        columns = [state[7 + 6 * j : 13 + 6 * j] for j in range(6)]
        return [
            one,
            *(dot(row, state[1:7]) + b for row, b in zip(matrix, forcing, strict=True)),
            *(dot(row, column) for column in columns for row in matrix),
        ]

    def values(state: Sequence[Number], before: Sequence[Number]) -> Values:
        # Element i, j of P stands in column j of the columns of the state.
        elements = [state[7 + 6 * (j - 1) + i - 1] for i, j in TRANSITION_ELEMENTS]
        return {"truth": state[1:7], "transition": elements}

    identity = [one if i == j else zero for j in range(6) for i in range(6)]
    initial = [zero, *map(ar.number, case.initial_errors), *identity]
    return Problem(field, initial, values, {"truth": (1,) * 6, "transition": (1,) * len(TRANSITION_ELEMENTS)})


def gyroscopic_problem(ar: BallArithmetic, case: GyroCase) -> Problem:
    """Return attitude, place, integrals of the sensors, and axes of gyropendulums."""
    problem = GyroscopicProblem(ar, case)
    return Problem(problem.field, problem.initial, problem.values, VECTORS)


#: Class of the cases -> what to integrate.
_PROBLEMS: Mapping[type, Callable[[BallArithmetic, Any], Problem]] = {
    DualPrecessionCase: precession_problem,
    EquatorCase: equator_problem,
    GyroCase: gyroscopic_problem,
}


def states(
    ar: BallArithmetic, problem: Equations, interval: Number, count: int, tail: float = _LOG_TAIL
) -> Iterator[list[Number]]:
    """Yield the state at the epochs 0 ... `count`.

    Parameters
    ----------
    ar : BallArithmetic
        Entered.
    problem : Equations
    interval : Number
        Distance of the epochs, s.
    count : int
    tail : float, optional
        Logarithm of what the last terms of a step may be beside the largest.
    """
    recorded = RecordedField(ar, problem.field, len(problem.initial))
    state = [x.mid() for x in problem.initial]
    yield state
    position = Fraction(0)  # in intervals: exact, so that every epoch is met exactly
    while position < count:
        series = recorded.coefficients(state, _ORDER)
        polynomials = [arb_poly(coefficients) for coefficients in series]
        reach = position + _step(series, float(interval), tail)
        epochs = range(floor(position) + 1, min(count, floor(reach)) + 1)
        for epoch in epochs:
            state = _at(polynomials, interval, epoch - position)
            yield state
        if not epochs:
            state = _at(polynomials, interval, reach - position)
        position = Fraction(epochs[-1]) if epochs else reach


def _at(polynomials: Sequence[Any], interval: Number, part: Fraction) -> list[Number]:
    time = interval * arb(fmpq(part.numerator, part.denominator))
    return [polynomial(time).mid() for polynomial in polynomials]


def _step(series: Sequence[Sequence[Number]], interval: float, tail: float) -> Fraction:
    """Return the step, in intervals, at which the last terms of each component vanish beside its largest."""
    sizes = np.array([[float(abs(x).log()) if x != 0 else -inf for x in terms] for terms in series])
    sizes = sizes[np.isfinite(sizes[:, 1:]).any(axis=1)]
    powers = np.arange(sizes.shape[1])
    shortest, longest = -100.0, 50.0  # logarithms
    for _ in range(30):
        middle = (shortest + longest) / 2
        terms = sizes + powers * middle
        if np.all(terms[:, -_LAST:].max(axis=1) <= terms.max(axis=1) + tail):
            shortest = middle
        else:
            longest = middle
    mantissa, exponent = frexp(float(np.exp(shortest)) / interval)
    return Fraction(ldexp(floor(mantissa * 256), exponent - 8))


def compare(case: Case, stored: Stored) -> dict[str, Worst]:
    """Integrate one case and return the largest relative difference of each table, in units of 1e-30.

    Of tables of values the largest difference in units of the accuracy that their columns state.

    Parameters
    ----------
    case : Case
    stored : mapping
        Only tables that the integration fills.
    """
    if isinstance(case, ErrorEquationCase):
        return _compare_recomputed(case, stored)
    if isinstance(case, MastCase):
        return _compare_values(case, stored)
    worst = {table: Worst() for table in stored}
    with BallArithmetic(_BITS) as ar:
        problem = _PROBLEMS[type(case)](ar, case)
        layouts = {table: _layout(_dataset_of(case), table) for table in stored}
        readers = {
            table: pair_rows(_dataset_of(case), table, paths, first, layouts[table].rows(case))
            for table, (paths, first) in stored.items()
        }
        scales = {table: [0.0] * len(problem.vectors[table]) for table in stored}
        before = list(problem.initial)
        for epoch, state in enumerate(states(ar, problem, ar.number(case.interval), case.samples)):
            values = problem.values(state, before)
            for table, reader in readers.items():
                if epoch or layouts[table].per_epoch(case):
                    error = _difference(values[table], next(reader), problem.vectors[table], scales[table])
                    worst[table].take(error / PAIR_TOLERANCE, f"{case.name}, epoch {epoch}")
            before = state
    return worst


def _compare_recomputed(case: ErrorEquationCase, stored: Stored) -> dict[str, Worst]:
    """As `compare`, for tables whose second path is an integration already: all their rows by it."""
    dataset, rows = _dataset_of(case), case.samples + 1
    batches = {}
    for table, (paths, first) in stored.items():
        columns = [half for name in pair_columns(dataset, table) for half in (name, f"{name}_lo")]
        whole = pa.concat_tables(slices(paths, columns, first, rows)).combine_chunks()
        (batches[table],) = whole.to_batches()
    return largest_errors(dataset, case, range(rows), batches)


def _compare_values(case: MastCase, stored: Stored) -> dict[str, Worst]:
    """As `compare`, for tables whose columns state an accuracy; one that shares another case's has no rows of it."""
    dataset = _dataset_of(case)
    worst = {table: Worst() for table in stored}
    rows = {table: _layout(dataset, table).rows(case) for table in stored}
    readers = {
        table: value_rows(dataset, table, paths, first, rows[table])
        for table, (paths, first) in stored.items()
        if rows[table]
    }
    columns = {table: computed_columns(dataset, table) for table in readers}
    with BallArithmetic(_BITS) as ar:
        problem = MastProblem(ar, case)
        parts = problem.states_per_step(readers)
        moving = states(ar, problem, ar.number(case.interval) / parts, parts * case.samples, _VALUE_TAIL)
        for epoch, found in enumerate(problem.rows(moving if readers else (), readers)):
            for table, exact in found.items():
                errors = row_errors(next(readers[table]), columns[table], exact)
                error, name = max(zip(errors, (column.name for column in columns[table]), strict=True))
                worst[table].take(error / PAIR_TOLERANCE, f"{case.name}, epoch {epoch}, {name}")
    return worst


def _difference(
    values: Sequence[Number], stored: Sequence[tuple[float, float]], vectors: Sequence[int], scales: list[float]
) -> float:
    """Return the largest relative difference of the vectors of a row; `scales` keeps the largest norms so far."""
    largest, place = 0.0, 0
    for number, width in enumerate(vectors):
        own, pairs = values[place : place + width], stored[place : place + width]
        norm = hypot(*map(float, own))
        scales[number] = max(scales[number], norm)
        error = hypot(*(float(x - arb(high) - arb(low)) for x, (high, low) in zip(own, pairs, strict=True)))
        relative = error / max(norm, _NEAR_ZERO * scales[number]) if scales[number] else (inf if error else 0.0)
        largest = max(largest, inf if relative != relative else relative)
        place += width
    return largest


def _dataset_of(case: Case) -> str:
    return next(dataset for dataset, of in CASE_CLASSES.items() if isinstance(case, of))


def _tables_of(case: Case) -> Collection[str]:
    """Return the tables that the integration of a case fills; none where its equations are not integrated here."""
    if isinstance(case, ErrorEquationCase):
        return [table for group in GROUPS[_dataset_of(case)] if group.exact_rows for table in group.tables]
    if isinstance(case, MastCase):
        return (PER_STEP, *PER_EPOCH)
    if type(case) not in _PROBLEMS:
        return ()
    with BallArithmetic(_BITS) as ar:
        return _PROBLEMS[type(case)](ar, case).vectors


def _layout(dataset: str, table: str) -> TableLayout:
    return TableLayout(table, groups_of(dataset, [table])[-1])


def integrate(
    folder: Path, workers: int = 2, progress: Callable[[int, int, str], None] = lambda done, total, what: None
) -> Iterator[Check]:
    """Compare every row of a dataset with its differential equations, integrated.

    Parameters
    ----------
    folder : Path
        A dataset that verifies otherwise; of `dual_precession` the tables ``truth``, ``increments``, ``mean_rates``,
        ``accumulated`` and ``resolved`` are compared, of `equator_errors` ``truth`` and ``transition``, of
        `error_equations`, `gyro_systems` and `mast_antenna` all.
    workers : int, default 2
        Processes.
    progress : callable, optional
        ``progress(cases done, cases in all, what)``.

    Yields
    ------
    Check

    Raises
    ------
    sinsdata.format.manifest.DatasetError
        If the folder is no dataset of this version, or one whose equations are not integrated here.
    """
    manifest = read_manifest(folder)
    dataset, cases = load_cases(folder)
    known = _tables_of(cases[0]) if cases else ()
    if not known:
        raise DatasetError(f"{folder}: the equations of {dataset} are not integrated here")
    files = {table: table_files(folder, manifest, table) for table in manifest["tables"] if table in known}
    layouts = {table: _layout(dataset, table) for table in files}
    tasks: list[Stored] = []
    passed = dict.fromkeys(files, 0)
    for case in cases:
        tasks.append({table: (paths, passed[table]) for table, paths in files.items()})
        passed = {table: first + layouts[table].rows(case) for table, first in passed.items()}
    worst = {table: Worst() for table in files}
    for number, found in enumerate(_results(cases, tasks, workers)):
        progress(number, len(cases), cases[number].name)
        for table, one in found.items():
            worst[table].take(one.size, one.where, one.count)
    unit = "values" if isinstance(cases[0], ErrorEquationCase) else "rows"
    for table, one in worst.items():
        what = f"{one.count} {unit} integrated from the differential equations"
        relative = f"relative difference {one.size * PAIR_TOLERANCE:.1e}"
        stated = f"{one.size:.1e} times the accuracy that is stated,"
        detail = f"{stated if isinstance(cases[0], MastCase) else relative} at {one.where}"
        yield Check(f"{folder}: {table}", what, one.size <= 1, detail)


def _results(cases: Sequence[Case], tasks: Sequence[Stored], workers: int) -> Iterator[dict[str, Worst]]:
    workers = min(workers, len(cases))
    if workers < 2:
        yield from map(compare, cases, tasks)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, initializer=follow_parent) as pool:
        yield from pool.map(compare, cases, tasks)
