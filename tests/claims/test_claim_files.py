"""The files of claims: what they hold, and how a mistake in one is reported."""

from fractions import Fraction

import pytest

from sinsbench.claims import PAPERS, ClaimFileError, load_claims
from sinsbench.claims.model import parse_claims, recipes
from sinsbench.claims.slips import SLIPS, TEXT_SLIPS

GOOD = """
[[claim]]
id = "speed"
where = "section 3"
quantity = "largest speed"
printed = "7440"
unit = "m/s"
recompute = { name = "largest_speed", height = "0" }
slip = { kind = "rounded down to a step", step = "10" }
note = "a remark"
"""
SLIP = '{ kind = "rounded down to a step", step = "10" }'


def _edited(old: str, new: str) -> str:
    assert old in GOOD
    return GOOD.replace(old, new)


def test_a_good_file() -> None:
    (claim,) = parse_claims(GOOD, "loginov2013", "mine.toml")
    assert (claim.paper, claim.id, claim.printed, claim.note) == ("loginov2013", "speed", "7440", "a remark")
    assert claim.recompute.name == "largest_speed"
    assert [slip.name for slip in claim.slips] == ["rounded down to a step"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[[claim]\n", "mine.toml: not TOML"),
        ("", "no claim"),
        ("paper = 1\n" + GOOD, "unknown key 'paper'"),
        (_edited('id = "speed"\n', ""), r"claim 1 \(without id\): key 'id' is missing"),
        (_edited('printed = "7440"\n', ""), r"claim 1 \(speed\): key 'printed' is missing"),
        (_edited('printed = "7440"', "printed = 7440"), r"\(speed\): printed = 7440 has the wrong type"),
        (_edited("note", "remark"), r"\(speed\): unknown key 'remark'"),
        (_edited("largest_speed", "largest_sped"), r"\(speed\): recompute: unknown name 'largest_sped'"),
        (_edited("height =", "altitude ="), r"\(speed\): recompute: largest_speed: argument 'height' is missing"),
        (
            _edited('height = "0"', 'height = "0", v = "1"'),
            "recompute: largest_speed: unknown argument 'v'",
        ),
        (_edited('{ name = "largest_speed", height = "0" }', '"largest_speed"'), "recompute = 'largest_speed' has"),
        (_edited("rounded down to a step", "rounded up"), r"\(speed\): slip: unknown kind 'rounded up'"),
        (_edited(SLIP, '{ step = "10" }'), r"\(speed\): slip: a table with the key 'kind'"),
        (_edited(SLIP, '["sign dropped"]'), r"\(speed\): slip: a table with the key 'kind'"),
        (_edited(SLIP, '{ kind = "copied from another cell", of = "x" }'), "refers to no other claim: 'x'"),
        (_edited(SLIP, '{ kind = "copied from another cell", of = "speed" }'), "refers to no other claim"),
        (GOOD + GOOD, r"claim 2 \(speed\): the id occurs twice"),
        (GOOD + 'beside = [{ name = "largest_sped" }]', r"\(speed\): beside: unknown name 'largest_sped'"),
        (GOOD + 'within = "1e-6"', r"\(speed\): within goes with a printed equality"),
        (_edited('"7440"', '"< 1"') + 'within = "1e-6"', r"\(speed\): within goes with a printed equality"),
        (_edited('"7440"', '"= 0"') + 'within = "small"', r"\(speed\): within = 'small': a decimal number"),
        (_edited('"7440"', '"= 0"') + 'within = "-1"', r"\(speed\): within = '-1': a decimal number"),
    ],
)
def test_a_mistake_is_named_with_file_and_claim(text: str, message: str) -> None:
    with pytest.raises(ClaimFileError, match=message) as caught:
        parse_claims(text, "loginov2013", "mine.toml")
    assert str(caught.value).startswith("mine.toml")
    assert "\n" not in str(caught.value)


def test_an_equality_has_a_margin() -> None:
    text = _edited('"7440"', '"= 0"') + 'within = "1e-6"\nbeside = [{ name = "largest_speed", height = "1" }]'
    (claim,) = parse_claims(text, "loginov2013", "mine.toml")
    assert (claim.within, [call.arguments for call in claim.beside]) == (Fraction(1, 10**6), [{"height": "1"}])


def test_an_unknown_paper() -> None:
    with pytest.raises(ValueError, match="no claims of paper 'newton1687'; there are: loginov2013, lebedev1989"):
        load_claims("newton1687")


@pytest.mark.parametrize("paper", PAPERS)
def test_every_recipe_and_every_kind_of_slip_is_used(paper: str) -> None:
    claims = load_claims(paper)
    told = {call.name for claim in claims for call in (*claim.tried, *claim.beside)}
    used = {claim.recompute.name for claim in claims} | told
    assert used == set(recipes(paper))


def test_every_slip_is_used() -> None:
    assert {slip.name for paper in PAPERS for claim in load_claims(paper) for slip in claim.slips} == set(SLIPS) | set(
        TEXT_SLIPS
    )


def test_all_tables_are_complete() -> None:
    """Tables 2 and 3: for each of three sets 6 errors, in three units for angles, and 1 or 2 channels that swing."""
    identifiers = [claim.id for claim in load_claims("loginov2013")]
    for table in ("table2", "table3"):
        counts = {s: sum(i.startswith(f"{table}.{s}.") for i in identifiers) for s in ("I", "II", "III")}
        # 6 errors + 2 units more of the angle, 4 (or 2) amplitudes + 2 units more, 4 (or 2) phases
        assert counts == {"I": 18, "II": 14, "III": 18}
    assert len(identifiers) == 129
    rows = [claim.id.split(".")[0] for claim in load_claims("lebedev1989")]
    assert [rows.count(name) for name in ("drift", "body_velocity", "inertial_velocity")] == [4, 12, 8]
