"""The findings behind what does not reproduce, as tables that are computed on demand.

`discrepancy_story`
    the 5e-4 m/s between the numerical and the analytical solution of Loginov, Tkachenko, Chelnokov 2013.
`short_mantissa_story`, `scale_error_story`
    the velocity errors of order 6 in the table of Lebedev, Panov 1989.
`methodical_story`, `orders_story`
    the errors of gyropendulum and bi-gyro in Chelnokov 1991, and how they vanish with the speed.
`assumptions_story`
    which figures of Sokolov, Pogorelov, Reshetnikova 2024 hold with which filter, satellites and noise.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, get_args

import numpy as np

from sinsbench.claims import discrepancy as check
from sinsbench.claims.gyroscopic_stories import methodical_errors, orders_in_speed
from sinsbench.claims.mast_stories import assumptions
from sinsbench.claims.precession_runs import (
    MOTIONS,
    Cell,
    FinalErrors,
    cell_values,
    errors,
    final_errors,
    fitted_scale,
    root_mean_square_log_ratio,
    sampled,
    scaled_errors,
    velocity_cells,
)
from sinsbench.subjects.rotation_vector_methods import PANOV_6

Rounding = Literal["nearest", "chop"]

#: Mantissas, in bits, that are tried in place of the 53 of binary64.
MANTISSAS = range(30, 45)


@dataclass(frozen=True)
class Story:
    """A finding.

    Attributes
    ----------
    name : str
        Short name.
    sentence : str
        What the rows show.
    rows : tuple of dict
        Rows with equal keys, which end in the SI unit of the value if it has one; values that JSON can hold.
    """

    name: str
    sentence: str
    rows: tuple[dict[str, Any], ...]


@cache
def discrepancy_story() -> Story:
    """Show which error can stay in dv_H alone: Loginov, Tkachenko, Chelnokov 2013, sections 3 and 4.

    Returns
    -------
    Story
        A row a computation: errors after two hours, largest error of dv_H and its instant, the ratio of the errors of
        dH and dv_H, and by how many orders the other components differ less from the printed formulas than dv_H.
    """
    rows = [check.row(name, check.errors_of(name)) for name in check.SOLVERS]
    rows += [
        check.row(f"constants (17) to {digits} digits", check.errors_of_rounded_constants(digits))
        for digits in check.ROUNDED_CONSTANTS
    ]
    printed = check.errors_of("equator_printed")
    largest, end = float(np.abs(printed[:, check.UP]).max()), float(abs(printed[-1, check.UP]))
    instants = ", ".join(f"{t:.0f}" for t in check.extremes(printed))
    sentence = (
        f"Row 2 of (22) as printed is wrong by up to {largest:.4g} m/s in dv_H, at {instants} s, and by nothing "
        f"elsewhere; at the end by {end:.4g} m/s, whatever the signs of the initial errors by "
        f"{check.largest_over_signs():.3g} m/s at most. An error of integration or of a constant excites the growing "
        f"mode, whose dH in m is {check.growth_length():.0f} times its dv_H in m/s, so it cannot stay in dv_H."
    )
    return Story("discrepancy", sentence, tuple(rows))


@cache
def short_mantissa_story() -> Story:
    """Run the algorithm of order 6 with short mantissas: Lebedev, Panov 1989, table of section 6.

    Returns
    -------
    Story
        A row a mantissa and rounding, with the velocity error of each printed cell and the root mean square of the
        logarithms of the ratios to the print; first the print, binary64, and binary64 with scaled rotation vectors.
    """
    cells = tuple(cell for cell in velocity_cells() if cell.order == "6")
    printed = {cell: cell.printed for cell in cells}
    exact = cell_values(lambda cell: errors("6", cell.variant, cell.motion), cells)
    scaled = cell_values(lambda cell: scaled_errors("6", cell.variant, cell.motion), cells)
    rows = [_row("printed", printed), _row("binary64", exact), _row("binary64, rotation vectors scaled", scaled)]
    rows += [
        _row(f"{bits} bits, {rounding}", _short_mantissa_values(cells, bits, rounding))
        for rounding in get_args(Rounding)
        for bits in MANTISSAS
    ]
    best = min(rows[3:], key=lambda row: float(row["rms_log_ratio"]))
    sentence = (
        f"Of mantissas of {MANTISSAS[0]} to {MANTISSAS[-1]} bits, {best['computation']} comes closest to the printed "
        f"velocity errors of order 6: rms of ln(value/printed) {best['rms_log_ratio']:.2g}, against "
        f"{rows[1]['rms_log_ratio']:.2g} in binary64 and {rows[2]['rms_log_ratio']:.2g} with one scale error of the "
        "rotation vectors for each motion."
    )
    return Story("short_mantissa", sentence, tuple(rows))


def _short_mantissa_values(cells: tuple[Cell, ...], bits: int, rounding: Rounding) -> dict[Cell, float]:
    # Imported here: it loads the compiler.
    from sinsbench.instrumentation import reduced_precision_integrator

    run = reduced_precision_integrator(PANOV_6, bits, rounding)

    @cache
    def of(variant: str, motion: str) -> FinalErrors:
        data = sampled(variant, motion)
        return final_errors(run, data, data.angle, data.velocity)

    return cell_values(lambda cell: of(cell.variant, cell.motion), cells)


def _row(name: str, values: Mapping[Cell, float]) -> dict[str, Any]:
    columns = {f"{cell.axes}_{cell.motion}_{cell.variant}_m_per_s": value for cell, value in values.items()}
    return {"computation": name, **columns, "rms_log_ratio": root_mean_square_log_ratio(values)}


@cache
def scale_error_story() -> Story:
    """Explain all printed velocity errors by one scale error of the rotation vectors for each motion.

    Returns
    -------
    Story
        A row a cell of Lebedev, Panov 1989, table of section 6: the print, the recomputed value, and the value with the
        fitted scale.
    """
    cells = velocity_cells()
    exact = cell_values(lambda cell: errors(cell.order, cell.variant, cell.motion), cells)
    scaled = cell_values(lambda cell: scaled_errors(cell.order, cell.variant, cell.motion), cells)
    rows = [
        {
            "order": cell.order,
            "motion": cell.motion,
            "variant": cell.variant,
            "axes": cell.axes,
            "printed_m_per_s": cell.printed,
            "recomputed_m_per_s": exact[cell],
            "with_scale_error_m_per_s": scaled[cell],
            "scale_error": fitted_scale(cell.motion),
        }
        for cell in cells
    ]
    kappas = ", ".join(f"{fitted_scale(motion):.3g} ({motion})" for motion in MOTIONS)
    worst = max(abs(scaled[cell] / cell.printed - 1) for cell in cells)
    before = max(abs(exact[cell] / cell.printed - 1) for cell in cells)
    sentence = (
        f"One scale error of every rotation vector for each motion, {kappas}, brings all {len(cells)} printed velocity "
        f"errors of orders 4 and 6 to within {100 * worst:.1f} % (without it: {100 * before:.0f} %). An error of "
        "arithmetic that repeats at every step acts so, as the angle of every step is the same: an inference, no proof."
    )
    return Story("scale_error", sentence, tuple(rows))


@cache
def methodical_story() -> Story:
    """Show what gyropendulum and bi-gyro of constant momentum err: Chelnokov 1991, section 2.1."""
    return Story("methodical_errors", *methodical_errors())


@cache
def orders_story() -> Story:
    """Show with which orders in the speed these errors vanish."""
    return Story("orders_in_speed", *orders_in_speed())


@cache
def assumptions_story() -> Story:
    """Show under which assumptions the figures of Sokolov, Pogorelov, Reshetnikova 2024 hold."""
    return Story("assumptions", *assumptions())


_STORIES: Mapping[str, tuple[Callable[[], Story], ...]] = {
    "loginov2013": (discrepancy_story,),
    "lebedev1989": (short_mantissa_story, scale_error_story),
    "chelnokov1991": (methodical_story, orders_story),
    "sokolov2024": (assumptions_story,),
}


def stories(paper: str) -> list[Story]:
    """Return the stories of a paper.

    Raises
    ------
    ValueError
        If the paper is unknown.
    """
    if paper not in _STORIES:
        raise ValueError(f"no stories of paper {paper!r}; there are: {', '.join(_STORIES)}")
    return [story() for story in _STORIES[paper]]
