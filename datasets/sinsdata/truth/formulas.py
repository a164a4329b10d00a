"""Which formula of `sinsref` fills which table, and in how many bits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from sinsdata.cases import DualPrecessionCase, EquatorCase, whole_intervals
from sinsdata.truth.certified import Block, RowFormula, blocks
from sinsref.arithmetic import Arithmetic, BallArithmetic, Number
from sinsref.equator import COUPLED, EquatorModel, guard_bits, transition
from sinsref.equator_forced import Misalignment, solution
from sinsref.equator_modes import Modes, NoRealModesError, modes
from sinsref.exact import ExactNumber
from sinsref.precession import increments
from sinsref.precession import solution as precession_solution
from sinsref.rounding import RoundingTally, round_value

#: Working precision of the first attempt: 106 bits for the pair, the rest for phases of many turns and for
#: cancellation. On the equator what `guard_bits` asks for is added.
WORKING_BITS = 192

#: Row and column (from 1) of the elements of P(t) that are not identically zero.
TRANSITION_ELEMENTS = tuple((i + 1, j + 1) for i in range(6) for j in range(6) if (i in COUPLED) == (j in COUPLED))


def increment_formula(case: DualPrecessionCase, interval: ExactNumber | None = None) -> RowFormula:
    """Return the formula of angle increments, rad, and velocity increments, m/s, of the sample that ends at a time.

    Parameters
    ----------
    case : DualPrecessionCase
    interval : ExactNumber, optional
        A sampling interval other than the case's, s.
    """
    step = interval or case.interval

    def formula(ar: Arithmetic, time: Number) -> Sequence[Number]:
        angle, velocity = increments(ar, case.motion, time, ar.number(step))
        return [*angle, *velocity]

    return formula


def precession_formula(case: DualPrecessionCase) -> RowFormula:
    """Return the formula of attitude and apparent velocity, inertial then body, m/s."""

    def formula(ar: Arithmetic, time: Number) -> Sequence[Number]:
        attitude, inertial, body = precession_solution(ar, case.motion, time)
        return [*attitude, *inertial, *body]

    return formula


def increment_blocks(
    case: DualPrecessionCase, tally: RoundingTally, interval: ExactNumber | None = None
) -> Iterator[Block]:
    """Yield the increments of the samples 1 ... n: six columns.

    Parameters
    ----------
    case : DualPrecessionCase
    tally : RoundingTally
    interval : ExactNumber, optional
        A sampling interval other than the case's, s; the duration must be a whole number of them.
    """
    step = interval or case.interval
    count = whole_intervals(case.duration, step) or 0
    return blocks(increment_formula(case, step), step, 1, count, WORKING_BITS, tally)


def precession_blocks(
    case: DualPrecessionCase, tally: RoundingTally, interval: ExactNumber | None = None
) -> Iterator[Block]:
    """Yield attitude and apparent velocity at the epochs 0 ... n: ten columns.

    Parameters
    ----------
    case, tally, interval
        As for `increment_blocks`.
    """
    step = interval or case.interval
    count = (whole_intervals(case.duration, step) or 0) + 1
    return blocks(precession_formula(case), step, 0, count, WORKING_BITS, tally)


def equator_bits(case: EquatorCase) -> int:
    """Return the working precision of the first attempt at a case."""
    with BallArithmetic(64) as balls:
        model = EquatorModel.at(balls, case.v_east, case.height)
        return WORKING_BITS + guard_bits(balls, model, balls.number(case.duration))


def equator_state(case: EquatorCase, solved: Callable[..., Sequence[Number]] = solution) -> RowFormula:
    """Return the formula of the six errors of a case.

    Parameters
    ----------
    case : EquatorCase
    solved : callable, optional
        Another form of the solution, called as `sinsref.equator_forced.solution` is.
    """

    def formula(ar: Arithmetic, time: Number) -> Sequence[Number]:
        initial = [ar.number(x) for x in case.initial_errors]
        tilt = None
        if case.misalignment is not None:
            elements = [[ar.number(x) for x in row] for row in case.misalignment]
            tilt = Misalignment(elements, ar.number(case.inertial_longitude))
        return solved(ar, EquatorModel.at(ar, case.v_east, case.height), initial, tilt, time)

    return formula


def equator_blocks(case: EquatorCase, tally: RoundingTally) -> Iterator[Block]:
    """Yield the six errors (m/s, m/s, m/s, m, rad, rad) at the epochs 0 ... n."""
    return blocks(equator_state(case), case.interval, 0, case.samples + 1, equator_bits(case), tally)


def transition_formula(case: EquatorCase) -> RowFormula:
    """Return the formula of the elements `TRANSITION_ELEMENTS` of P(t)."""

    def formula(ar: Arithmetic, time: Number) -> Sequence[Number]:
        matrix = transition(ar, EquatorModel.at(ar, case.v_east, case.height), time)
        return [matrix[i - 1][j - 1] for i, j in TRANSITION_ELEMENTS]

    return formula


def equator_modes(case: EquatorCase, tally: RoundingTally) -> dict[str, tuple[float, float] | None]:
    """Return the constants of (17) as pairs, None where the modes are not real."""

    def constant(name: str, ar: Arithmetic) -> Number:
        return getattr(modes(ar, EquatorModel.at(ar, case.v_east, case.height)), name)

    names = Modes.__dataclass_fields__
    try:
        pairs = {name: round_value(partial(constant, name), tally) for name in names}
    except NoRealModesError:
        return dict.fromkeys(names)
    tally.values += len(names)
    return dict(pairs)
