"""Defects that make no difference, each with the reason.

An entry explains a defect of which neither the score nor random inputs show anything; one that they show is told apart
or has survived, whatever stands here.
"""

import re
from typing import NamedTuple

__all__ = ["EQUIVALENTS", "Equivalent", "reason_of"]


class Equivalent(NamedTuple):
    """A kind of defect that makes no difference.

    Attributes
    ----------
    subjects, defects : str
        Regular expressions: names of the subjects, and descriptions of the defects without that of the module.
    reason : str
        Why it makes none.
    """

    subjects: str
    defects: str
    reason: str


_ROUNDING = "less than ten roundings of the result, at the largest angle that the series serve"
_SMALL_PRODUCT = "less than ten roundings: coefficients of high degree are small, and their products smaller"
_GUARD = "a guard against what the formula does not meet: dividing by exactly zero"
_THRESHOLD = "on both sides of this threshold two ways of computing agree to rounding"
_BOUND = (
    "a bound that decides when to stop; with this one more terms are taken than matter, or none that do are left out"
)
_UNUSED = "computed, and not used by this subject"

EQUIVALENTS = (
    # Power series
    Equivalent(".*_savage(_third)?", r"dual\[\d\] .*", "a classical velocity update takes the rotation alone"),
    Equivalent(
        ".*",
        r"(cosine|sine)\[6\] times 1\.001|(cosine|sine)\[7\] .*|dual\[5\] times 1\.001|dual\[[67]\] .*",
        _ROUNDING,
    ),
    Equivalent(
        "taylor.*",
        r"reciprocals\[(1[5-9]|[2-9]\d|1\d\d)\] .*",
        "less than ten roundings, at the largest rotation of a step: terms so high are small, or not taken",
    ),
    Equivalent("quatfiter.*", r"integrals\[(\d+, ([4-9]|[12]\d)|([4-9]|[12]\d), \d+)\] .*", _SMALL_PRODUCT),
    # Kernels
    Equivalent(".*", r"polynomial: .*len\(coefficients\) - 1 -> -1", "the same entry, the last"),
    Equivalent(".*", r"polynomial: range\(len\(coefficients\) - 2, -1, -1\): 2 -> 1", _ROUNDING),
    Equivalent(
        ".*",
        r"polynomial: .*: value \* x \+ coefficients\[k\] -> value \* x - coefficients\[k\]",
        "all coefficients but the last change sign, and with them both quaternions of the step: the same motion",
    ),
    Equivalent(".*", r"increment_sum: range\(.*", "a step of one sample has no others to add"),
    Equivalent(
        ".*",
        r"(step|compensated_step|resolved_gain): c(oefficients)?\.resolving\[[01]\] != 0\.0: .*",
        "both coefficients of the rule are zero or neither is, or a term with the coefficient zero is computed",
    ),
    Equivalent(
        ".*", r"velocity_gains: return .*", "of the two gains only the first is used, that at the start of a step"
    ),
    # Fitted methods
    Equivalent(
        "magnus.*|quatfiter.*", r"(quaternion_at|place): .*: first \+ (\d) -> \2", "the columns begin with the first"
    ),
    Equivalent(".*", r"weighted_sum: range\(1, weights\.shape\[1\]\): 1 -> 0.*", "the matrices of a fit are square"),
    Equivalent(
        "(taylor|quatfiter|magnus).*",
        r"(terms_needed|length|integrate_product|iterate_attitude): .*",
        _BOUND,
    ),
    Equivalent(
        "(taylor|quatfiter|magnus).*",
        r"fit_step: .*: (last - (inner|i) -> last( \+ \2)?|2 -> 1|2 \* j \+ [12] -> [12])( .*)?",
        "of so few samples the only index is 0; fits to more of them tell it apart",
    ),
    Equivalent(
        "magnus.*", r"mean.*|half.*|fit_step: (constant|out\[0, axis\]) = .*", "no generator takes the mean rate"
    ),
    Equivalent(
        "magnus.*",
        r"magnus_generators: (range.*|(second|third) = add.*|first = .*)",
        "the constant coefficient has the weight 0; of two samples there is no third generator",
    ),
    Equivalent("taylor.*|magnus.*", r"fit_step: out\[last \+ 1, axis\] = total: .*", _UNUSED),
    Equivalent("quatfiter.*", r"velocity_gained: .*len\(force\) - 1 -> -1", "the same entry, the last"),
    Equivalent("quatfiter.*", r"velocity_gained: range\(m % 2, .*: 2 -> 1.*", "the integrals in between are zero"),
    Equivalent(
        "taylor.*",
        r"series_gain: (highest_even, .*|range\(1, terms \+ 1\): .*|place\(series, 0, 4, .*)"
        r"|power_series: terms == 0: .*",
        "a term more or less than those that matter; a row that is written again before it is read",
    ),
    # Solvers of the equator error equations
    Equivalent(
        "equator_.*",
        r"forcing_matrix: coefficients( = .*|\[0\] = .*|\[[12]\] = .*: 0\.0 -> 1\.0.*)",
        "the particular solution takes the constants and second harmonics of the up and east rows alone",
    ),
    Equivalent(
        "equator_(?!printed).*", r": _PRINTED_OSCILLATION = .*|: \(2, \d\): .*", "read by the printed edition alone"
    ),
    Equivalent("equator_printed", r": _Element\(2, .*", "the printed edition has another number in the second row"),
    Equivalent(".*", r"particular_solution: chi == 0 or stiffness == 0: .*", _GUARD),
    Equivalent(".*", r"(state_scale|schuler_speed): .*", "a unit, which cancels"),
    Equivalent(
        "rk45|dop853|radau|lsoda",
        r": (ABSOLUTE|RELATIVE)_TOLERANCE = .*|_integrate: solution = .*: .*TOLERANCE.*",
        "relative: less than the solver accepts, which takes its least; absolute: below every error",
    ),
    Equivalent(
        "rk45|dop853|radau|lsoda", r"_integrate: instants\.size == 0 or .*", "a guard for no time to integrate over"
    ),
    Equivalent("ode45_.*", r"method: instants\.size == 1: .*", "a guard for no time to integrate over"),
    Equivalent("ode45_.*", r": np\.array\(.*: zip\(.*", "of the estimated error only the size is used"),
    Equivalent(
        "ode45_.*",
        r"ode45: (rejected, evaluations, wanted = \(0, 1, 1\): (0 -> 1|1 -> 0)|steps = 0: .*|steps \+= 1: .*"
        r"|evaluations \+= 6: .*|rejected \+= 1: .*)",
        "a count of the work, which is no part of the solution",
    ),
    Equivalent(
        "ode45_.*",
        r"ode45: rejected, evaluations, wanted = \(0, 1, 1\): 1 -> 0 \(2\)",
        "the start is interpolated once more, and is the start",
    ),
    Equivalent(
        "ode45_.*", r"ode45: every_step = .*", "of a single instant: the last step ends there, interpolated or not"
    ),
    Equivalent("ode45_.*", r"ode45: instants\.ndim != 1 or .*: 2 -> 1", "a guard: there are two instants or more"),
    Equivalent(
        "ode45_.*", r"ode45: (largest|size = min).*(end|float\(instants\[1\]\)) - time -> .*", "the time starts at zero"
    ),
    Equivalent(
        "ode45_.*",
        r"ode45: (smallest = .*|factor = .*: 0\.1 -> .*)",
        "a bound on the step, or on its change, that smooth motion never meets",
    ),
    Equivalent("ode45_(?!tightest).*", r": SMALLEST_RELATIVE_TOLERANCE = .*", "smaller than the tolerance asked for"),
    *(
        Equivalent(f"ode45_(?!{name}).*", rf": \({tolerance}, .*", "the tolerances of another subject")
        for name, tolerance in {
            "1e-3": r"0\.001",
            "1e-6": "1e-06",
            "1e-9": "1e-09",
            "1e-12": "1e-12",
            "tightest": r"2\.22e-14",
        }.items()
    ),
    Equivalent(
        "ode45_1e-12|ode45_tightest",
        r": (SMALLEST_RELATIVE_TOLERANCE = .*|\((1e-12, 1e-12|2\.22e-14, 1e-20)\): (1e-12|2\.22e-14) -> [^(]*)"
        r"|ode45: factor = .*: 0\.5 -> .*",
        "less than ten roundings: a thousandth of an error that is hardly larger",
    ),
    Equivalent(".*", r"harmonics: .*: 1 -> 0", "the angle is one number, whose only axis is the last"),
    Equivalent(".*", r": (DOUBLE_ROOT|SERIES_LIMIT|SERIES_TERMS|CANCELLATION) = .*", _THRESHOLD),
    Equivalent(".*", r"_roots: discriminant <= DOUBLE_ROOT \* p \* p: .*", _THRESHOLD),
    Equivalent(".*", r"_early: return .*|_particular_solution_cancels: return .*", _THRESHOLD),
    Equivalent(
        ".*",
        r".*: (\w+)\((rho1), (rho2), time\) -> \1\(\3, \2, time\)",
        "divided differences and the larger of two do not change when the roots change places",
    ),
)
"""The first entry that matches a subject and a defect gives the reason."""


def reason_of(subject: str, defect: str) -> str:
    """Return why a defect makes no difference; an empty text for no known reason.

    Parameters
    ----------
    subject : str
        Name of the subject.
    defect : str
        Description of the defect, that of a term preceded by its module and a full stop.
    """
    described = re.sub(r"^\w+\.(?=\w*: )", "", defect)
    return next(
        (x.reason for x in EQUIVALENTS if re.fullmatch(x.subjects, subject) and re.fullmatch(x.defects, described)), ""
    )
