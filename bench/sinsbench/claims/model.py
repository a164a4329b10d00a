"""Claims as data: what a paper prints, where, and how it is recomputed.

The files ``<paper>.toml`` beside this module hold one ``[[claim]]`` a printed number or statement, with the keys

``id, where, quantity, printed, unit``
    strings; `printed` has exactly the digits of the paper, with a decimal point and ``e`` for the power of ten. Of a
    statement without figures it is a relation, ``= 0``, ``< 1``, ``> 1``; of an equation a form of it, as words.
``recompute``
    a recipe: its name and its arguments.
``slip`` (optional)
    a named slip, or a list of slips one after the other, that would have led from the right value to the printed one.
``tried`` (optional)
    list of recipes that were tried as explanations.
``beside`` (optional)
    list of recipes whose values stand in the note, whatever the verdict: the numbers that set its condition.
``within`` (optional)
    a decimal number as a string: the difference up to which an equality counts, in the unit of the claim.
``note`` (optional)
    a remark.
"""

import inspect
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from fractions import Fraction
from importlib import import_module, resources
from typing import Any

from sinsbench.claims.quantities import printed_number, printed_relation
from sinsbench.claims.slips import SLIPS, TEXT_SLIPS

PAPERS = ("loginov2013", "lebedev1989", "chelnokov1991", "sokolov2024")
VERDICTS = ("reproduced", "misprint", "not reproduced")

_RECIPE_MODULES = {
    "loginov2013": "sinsbench.claims.equator_recipes",
    "lebedev1989": "sinsbench.claims.precession_recipes",
    "chelnokov1991": "sinsbench.claims.gyroscopic_recipes",
    "sokolov2024": "sinsbench.claims.mast_recipes",
}
_REQUIRED = {"id": str, "where": str, "quantity": str, "printed": str, "unit": str, "recompute": dict}
_OPTIONAL = {"slip": dict | list, "tried": list, "beside": list, "within": str, "note": str}
_SLIPS: Mapping[str, Callable[..., Any]] = {**SLIPS, **TEXT_SLIPS}


class ClaimFileError(ValueError):
    """A file of claims is not as it must be; the message names the file, the claim and the key."""


@dataclass(frozen=True)
class Call:
    """A recipe or a slip by name, with its arguments."""

    name: str
    arguments: Mapping[str, Any]


@dataclass(frozen=True)
class Claim:
    """A printed number, statement or equation.

    Attributes
    ----------
    paper, id, where, quantity : str
        The paper's name, a key unique in it, the place, and what the number is.
    printed : str
        Exactly what is printed.
    unit : str
        Unit of the printed number; empty for a word or a pure number.
    recompute : Call
        The recipe.
    slips : tuple of Call
        Slips, in the order they would have been made.
    tried : tuple of Call
        Recipes that were tried as explanations.
    beside : tuple of Call
        Recipes whose values are told beside the verdict.
    within : Fraction
        The difference up to which an equality counts.
    note : str
        A remark.
    """

    paper: str
    id: str
    where: str
    quantity: str
    printed: str
    unit: str
    recompute: Call
    slips: tuple[Call, ...] = ()
    tried: tuple[Call, ...] = ()
    beside: tuple[Call, ...] = ()
    within: Fraction = Fraction(0)
    note: str = ""


@dataclass(frozen=True)
class ClaimResult:
    """A claim with its verdict.

    Attributes
    ----------
    paper, id, where, quantity, printed, unit : str
        As in `Claim`.
    computed : float or str
        The recomputed value in the printed unit; of an equation the form that holds.
    relative_difference : float or None
        (printed - computed) / computed; None for words and relations, and where it is not defined.
    rounds_to_printed : bool
        Whether the recomputed value rounds to what is printed, or has the printed relation.
    verdict : str
        ``reproduced``; ``misprint``, if the named slip leads from the recomputed value to the printed one; or
        ``not reproduced``.
    note : str
        The slip and the right value, or what was tried, and remarks.
    """

    paper: str
    id: str
    where: str
    quantity: str
    printed: str
    unit: str
    computed: float | str
    relative_difference: float | None
    rounds_to_printed: bool
    verdict: str
    note: str

    def to_row(self) -> dict[str, Any]:
        """Return the fields as a dictionary that JSON can hold."""
        return asdict(self)


def recipes(paper: str) -> Mapping[str, Callable[..., Any]]:
    """Return the recipes of a paper by name.

    Raises
    ------
    ValueError
        If the paper is unknown.
    """
    if paper not in _RECIPE_MODULES:
        raise ValueError(f"no claims of paper {paper!r}; there are: {', '.join(PAPERS)}")
    table: Mapping[str, Callable[..., Any]] = import_module(_RECIPE_MODULES[paper]).RECIPES
    return table


def load_claims(paper: str) -> tuple[Claim, ...]:
    """Read the claims of a paper.

    Parameters
    ----------
    paper : str
        One of `PAPERS`.

    Raises
    ------
    ValueError
        If the paper is unknown.
    ClaimFileError
        If the file is not as it must be.
    """
    recipes(paper)
    name = f"{paper}.toml"
    return parse_claims((resources.files(__package__) / name).read_text(encoding="utf-8"), paper, name)


def recorded_verdicts(paper: str) -> Mapping[str, str]:
    """Return the verdicts other than ``reproduced`` on record, by claim id.

    Verdicts are computed; the record in ``verdicts.toml`` only shows when one changes.
    """
    record = tomllib.loads((resources.files(__package__) / "verdicts.toml").read_text(encoding="utf-8"))
    return {identifier: verdict for verdict, ids in record[paper].items() for identifier in ids}


def parse_claims(text: str, paper: str, name: str) -> tuple[Claim, ...]:
    """Parse and check the text of a file of claims.

    Parameters
    ----------
    text : str
        TOML.
    paper : str
        The paper, which decides on the recipes.
    name : str
        Name of the file, for messages.

    Raises
    ------
    ClaimFileError
        For broken TOML, a missing, unknown or ill-typed key, an id that occurs twice, an unknown recipe or slip,
        arguments that it does not take, or a slip that refers to no other claim.
    """
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ClaimFileError(f"{name}: not TOML: {error}") from None
    unknown = sorted(set(document) - {"claim"})
    tables = document.get("claim")
    if unknown or not isinstance(tables, list):
        what = f"unknown key {unknown[0]!r}" if unknown else "no claim"
        raise ClaimFileError(f"{name}: {what}; a file of claims holds [[claim]] tables and nothing else")
    claims: dict[str, Claim] = {}
    for number, table in enumerate(tables, start=1):
        claim = _claim(table, paper, f"{name}: claim {number} ({table.get('id', 'without id')})")
        if claim.id in claims:
            raise ClaimFileError(f"{name}: claim {number} ({claim.id}): the id occurs twice")
        claims[claim.id] = claim
    for claim in claims.values():
        for slip in claim.slips:
            other = slip.arguments.get("of")
            if other is not None and (other not in claims or other == claim.id):
                raise ClaimFileError(f"{name}: claim {claim.id}: slip refers to no other claim: {other!r}")
    return tuple(claims.values())


def _claim(table: Mapping[str, Any], paper: str, where: str) -> Claim:
    for key in _REQUIRED:
        if key not in table:
            raise ClaimFileError(f"{where}: key {key!r} is missing")
    kinds = {**_REQUIRED, **_OPTIONAL}
    for key, value in table.items():
        if key not in kinds:
            raise ClaimFileError(f"{where}: unknown key {key!r}; admissible: {', '.join(kinds)}")
        if not isinstance(value, kinds[key]):
            raise ClaimFileError(f"{where}: {key} = {value!r} has the wrong type")
    slips = table.get("slip", [])
    known = recipes(paper)
    within = printed_number(table.get("within", "0"))
    if within is None or within < 0:
        raise ClaimFileError(f"{where}: within = {table['within']!r}: a decimal number not below 0 is needed")
    relation = printed_relation(table["printed"])
    if "within" in table and (relation is None or relation.sign != "="):
        raise ClaimFileError(f"{where}: within goes with a printed equality, such as '= 0'")
    return Claim(
        paper=paper,
        **{key: table[key] for key in ("id", "where", "quantity", "printed", "unit")},
        recompute=_call(table["recompute"], "name", known, f"{where}: recompute"),
        slips=tuple(
            _call(slip, "kind", _SLIPS, f"{where}: slip") for slip in (slips if isinstance(slips, list) else [slips])
        ),
        tried=tuple(_call(recipe, "name", known, f"{where}: tried") for recipe in table.get("tried", [])),
        beside=tuple(_call(recipe, "name", known, f"{where}: beside") for recipe in table.get("beside", [])),
        within=Fraction(within),
        note=table.get("note", ""),
    )


def _call(table: Any, key: str, known: Mapping[str, Callable[..., Any]], where: str) -> Call:
    """Check a name and the arguments against the signature of the function they call."""
    if not isinstance(table, dict) or not isinstance(table.get(key), str):
        raise ClaimFileError(f"{where}: a table with the key {key!r} is needed, not {table!r}")
    name = table[key]
    # Tuples: recipes are remembered by their arguments.
    arguments = {k: tuple(v) if isinstance(v, list) else v for k, v in table.items() if k != key}
    if name not in known:
        raise ClaimFileError(f"{where}: unknown {key} {name!r}; admissible: {', '.join(known)}")
    wanted = [p for p in inspect.signature(known[name]).parameters.values() if p.kind is p.KEYWORD_ONLY]
    missing = [p.name for p in wanted if p.default is p.empty and p.name not in arguments]
    unknown = sorted(set(arguments) - {p.name for p in wanted})
    if missing or unknown:
        what = f"argument {missing[0]!r} is missing" if missing else f"unknown argument {unknown[0]!r}"
        raise ClaimFileError(f"{where}: {name}: {what}")
    return Call(name, arguments)
