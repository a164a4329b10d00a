"""From a claim to its verdict."""

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from functools import cache
from typing import Any

from sinsbench.claims.model import Call, Claim, ClaimResult, load_claims, recipes
from sinsbench.claims.quantities import Enclosure, Quantity, printed_number, rounds_to, significant_digits, written_like
from sinsbench.claims.slips import SLIPS, TEXT_SLIPS, Setting


def evaluate(paper: str) -> list[ClaimResult]:
    """Recompute every number and statement of a paper and judge it.

    Parameters
    ----------
    paper : str
        One of `PAPERS`.

    Returns
    -------
    list of ClaimResult
        In the order of the paper. What was computed is kept for the life of the process.

    Raises
    ------
    ValueError
        If the paper is unknown.
    """
    return evaluate_claims(load_claims(paper))


def evaluate_claims(claims: Iterable[Claim]) -> list[ClaimResult]:
    """Judge claims; slips may refer to any claim among them."""
    table = {claim.id: claim for claim in claims}

    def reproduced(identifier: str) -> bool:
        claim = table[identifier]
        return rounds_to(_recomputed(claim).in_unit(claim.unit), claim.printed, claim.within)

    return [_judge(claim, table.__getitem__, reproduced) for claim in table.values()]


def _recomputed(claim: Claim) -> Quantity:
    return _run(claim.paper, claim.recompute.name, tuple(sorted(claim.recompute.arguments.items())))


@cache
def _run(paper: str, name: str, arguments: tuple[tuple[str, Any], ...]) -> Quantity:
    quantity: Quantity = recipes(paper)[name](**dict(arguments))
    return quantity


def _judge(claim: Claim, other: Callable[[str], Claim], reproduced: Callable[[str], bool]) -> ClaimResult:
    quantity = _recomputed(claim)
    value = quantity.in_unit(claim.unit)
    setting = Setting(claim.printed, claim.unit, quantity.radius, other, reproduced)
    rounds = rounds_to(value, claim.printed, claim.within)
    remarks = [*_findings(quantity, claim.printed), *map(_sentence(claim), claim.beside), *filter(None, [claim.note])]
    if rounds:
        verdict = "reproduced"
    elif claim.slips and _tested(quantity, claim.printed) and _explains(value, claim.slips, setting):
        verdict = "misprint"
        kinds = ", ".join(dict.fromkeys(slip.name for slip in claim.slips))
        remarks.insert(0, f"{kinds}; correct: {written_like(value, claim.printed)}")
    else:
        verdict = "not reproduced"
        attempts = [f"tried {sentence}" for sentence in map(_sentence(claim), claim.tried)]
        remarks = [f"recomputed: {written_like(value, claim.printed)}", *attempts, *remarks]
    return ClaimResult(
        paper=claim.paper,
        id=claim.id,
        where=claim.where,
        quantity=claim.quantity,
        printed=claim.printed,
        unit=claim.unit,
        computed=value if isinstance(value, str) else float(value.middle),
        relative_difference=_relative_difference(value, claim.printed),
        rounds_to_printed=rounds,
        verdict=verdict,
        note="; ".join(remarks),
    )


def _tested(quantity: Quantity, printed: str) -> bool:
    """Tell whether the printed form of an equation is one of those put to the test; a number has no forms."""
    return not quantity.findings or printed in quantity.findings


def _explains(value: Enclosure | str, slips: Iterable[Call], setting: Setting) -> bool:
    slipped: Enclosure | str | None = value
    for slip in slips:
        table: Mapping[str, Callable[..., Enclosure | str | None]]
        table = TEXT_SLIPS if isinstance(slipped, str) else SLIPS
        if slipped is None or slip.name not in table:
            return False
        slipped = table[slip.name](slipped, setting, **slip.arguments)
    return slipped is not None and rounds_to(slipped, setting.printed)


def _findings(quantity: Quantity, printed: str) -> list[str]:
    """Return what was found of the printed word, of the right one, and of others by name."""
    names = {printed: "printed form", quantity.value: "right form"}
    return [f"{names.get(word, word)}: {finding}" for word, finding in quantity.findings.items()]


def _sentence(claim: Claim) -> Callable[[Call], str]:
    def sentence(call: Call) -> str:
        quantity = _run(claim.paper, call.name, tuple(sorted(call.arguments.items())))
        given = claim.recompute.arguments
        # What the claim itself says need not be said again.
        named = ", ".join(f"{key} {_listed(value)}" for key, value in call.arguments.items() if given.get(key) != value)
        same = quantity.unit == claim.unit
        plain = same or printed_number(claim.printed) is None
        number = written_like(quantity.value, _style_of_attempt(claim.printed) if plain else "1.000e0")
        recipe = call.name.replace("_", " ") + (f" ({named})" if named else "")
        return f"{recipe}: {number}{'' if same or not quantity.unit else ' ' + quantity.unit}"

    return sentence


def _listed(value: Any) -> str:
    return ", ".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _style_of_attempt(printed: str) -> str:
    """Return the print, or a number in its style with three digits if it has fewer: attempts shall be told apart."""
    number = printed_number(printed)
    if number is None or significant_digits(number) >= 3:
        return printed
    return "1.00e0" if "e" in printed else "1.00"


def _relative_difference(value: Enclosure | str, printed: str) -> float | None:
    number = printed_number(printed)
    if isinstance(value, str) or number is None:
        return None
    if not value.middle:
        return None if number else 0.0
    return float((Fraction(number) - value.middle) / value.middle)
