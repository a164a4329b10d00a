"""The files around the packages: versions, licences, layout, cards and pages, read from this checkout.

The packages themselves are the installed ones: the wheel is compared with the checkout it was built from.
"""

import re
import tomllib
from importlib.metadata import distribution
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import sinsbench

ROOT = Path(__file__).resolve().parents[1]
ROOMS = {"reference": "sinsref", "datasets": "sinsdata", "bench": "sinsbench"}
CARDS = sorted((ROOT / "datasets" / "cards").glob("*.md"))
PAPERS = sorted((ROOT / "reference" / "papers").glob("*.md"))
PAGES = [*sorted(ROOT.glob("*.md")), *PAPERS, *CARDS]

# The columns that users may rely on. A card explains all of them, and may explain more.
TRANSITION_ELEMENTS = "11 15 22 23 24 26 32 33 34 36 42 43 44 46 51 55 62 63 64 66"
PROMISED_COLUMNS = {
    ("equator_errors", "truth"): "case time dv_north dv_up dv_east d_height d_latitude d_longitude",
    ("equator_errors", "modes"): "case beta3 omega mu",
    ("equator_errors", "transition"): "case time p" + TRANSITION_ELEMENTS.replace(" ", " p"),
    ("dual_precession", "increments"): ("case sample time angle_x angle_y angle_z velocity_x velocity_y velocity_z"),
    ("dual_precession", "truth"): (
        "case sample time q_w q_x q_y q_z w_inertial_x w_inertial_y w_inertial_z w_body_x w_body_y w_body_z"
    ),
    ("error_equations", "truth"): "case time dv_north dv_up dv_east d_height d_latitude d_longitude",
    ("error_equations", "linearisation"): "case time dv_north dv_up dv_east d_height d_latitude d_longitude",
    ("gyro_systems", "sensors"): "case time angular_rate_x specific_force_z angle_y velocity_x",
    ("gyro_systems", "truth"): "case time latitude longitude heading pitch roll speed q_w trihedron_w vertical_x",
    ("gyro_systems", "reference"): "case time paper_gyro_x paper_bisector_z rest_mirror_y",
    ("mast_antenna", "sensors"): "case sample time start_angular_rate1_x end_specific_force2_z noise_angular_rate2_y",
    ("mast_antenna", "satellites"): "case time satellite1_x satellite4_velocity_z range_rate1 range4",
    ("mast_antenna", "measurements"): "case time range_rate1 range1 range_rate4 range4",
    ("mast_antenna", "truth"): "case time mu_w lambda_x eta_y nu_z longitude latitude v_north mast_absolute_rate_x",
}


def _project() -> dict[str, Any]:
    project: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return project


def _citation() -> dict[str, str]:
    """Return the top-level entries of CITATION.cff; an entry that is a list or a block has the value ''."""
    lines = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    entries = (re.fullmatch(r"([a-z-]+):(?: +(.*))?", line) for line in lines if line and line[0] not in " #")
    return {entry[1]: (entry[2] or "").strip("'\"") for entry in entries if entry}


def _front_matter(page: Path) -> str:
    match = re.match(r"---\n(.*?)\n---\n", page.read_text(encoding="utf-8"), re.DOTALL)
    assert match, f"{page.name} does not begin with a block of YAML"
    return match[1]


def _card_columns(card: Path) -> dict[str, list[str]]:
    """Return the columns that a card lists under each of its tables."""
    columns: dict[str, list[str]] = {}
    tables = re.split(r"^### ", card.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    for table in tables:
        rows = re.findall(r"^\| ([a-z0-9_, ]+?) \|", table, re.MULTILINE)
        assert rows[0] == "column"
        columns[table.split("\n", 1)[0]] = [name for row in rows[1:] for name in row.split(", ")]
    return columns


def test_the_version_is_the_same_everywhere() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    newest = re.search(r"^## \[(.+?)\]", changelog, re.MULTILINE)
    assert newest
    version = _project()["version"]
    assert newest[1] == version
    assert _citation()["version"] == version
    assert sinsbench.__version__ == version
    assert distribution("sinsbench").version == version


def test_the_citation_file_has_what_version_1_2_0_of_the_format_requires() -> None:
    citation = _citation()
    assert citation["cff-version"] == "1.2.0"
    assert citation["message"]
    assert citation["title"]
    assert {"authors", "references"} <= citation.keys()
    assert citation["license"] in _project()["license"].split(" AND ")


def test_the_distribution_carries_both_licences() -> None:
    assert distribution("sinsbench").metadata["License-Expression"] == _project()["license"]
    installed = {path.name: path for path in distribution("sinsbench").files or []}
    for name in _project()["license-files"]:
        text = (ROOT / name).read_text(encoding="utf-8")
        assert len(text) > 1000, f"{name} is not the text of a licence"
        assert installed[name].read_text() == text


@pytest.mark.parametrize(("room", "package"), ROOMS.items())
def test_the_wheel_holds_every_file_of_the_package(room: str, package: str) -> None:
    spec = find_spec(package)
    assert spec
    assert spec.submodule_search_locations
    installed = Path(spec.submodule_search_locations[0])
    sources = [
        path
        for path in (ROOT / room / package).rglob("*")
        if path.is_file() and path.suffix not in {".pyc", ".nbi", ".nbc"}
    ]
    assert any(path.name == "py.typed" for path in sources)
    for path in sources:
        copy = installed / path.relative_to(ROOT / room / package)
        assert copy.read_bytes() == path.read_bytes()


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_is_a_folder_and_not_a_package(room: str) -> None:
    # datasets/__init__.py would hide Hugging Face's package of that name from a Python started here.
    assert (ROOT / room).is_dir()
    assert not (ROOT / room / "__init__.py").exists()


def test_modules_stay_under_400_lines() -> None:
    lengths = {
        str(path.relative_to(ROOT)): path.read_text(encoding="utf-8").count("\n")
        for room in (*ROOMS, "tests")
        for path in (ROOT / room).rglob("*.py")
    }
    assert lengths
    assert {name: length for name, length in lengths.items() if length >= 400} == {}


def test_every_promised_table_has_a_card() -> None:
    assert {dataset for dataset, _ in PROMISED_COLUMNS} == {card.stem for card in CARDS}


@pytest.mark.parametrize("card", CARDS, ids=lambda card: card.stem)
def test_the_front_matter_of_a_card_describes_its_tables(card: Path) -> None:
    front_matter = _front_matter(card)
    for line in (f'pretty_name: "{card.stem}: ', "license: cc0-1.0", "tags:", "size_categories:", "configs:"):
        assert re.search(f"^{re.escape(line)}", front_matter, re.MULTILINE), line
    names = re.findall(r"^  - config_name: (\w+)$", front_matter, re.MULTILINE)
    files = re.findall(r"^        path: \w+/(\w+)\.parquet$", front_matter, re.MULTILINE)
    assert names == files
    assert sorted(names) == sorted(_card_columns(card))
    assert front_matter.count("default: true") == 1


@pytest.mark.parametrize(("dataset", "table"), PROMISED_COLUMNS)
def test_a_card_explains_the_promised_columns(dataset: str, table: str) -> None:
    explained = _card_columns(ROOT / "datasets" / "cards" / f"{dataset}.md")[table]
    assert len(set(explained)) == len(explained)
    assert set(PROMISED_COLUMNS[dataset, table].split()) <= set(explained)


@pytest.mark.parametrize("card", CARDS, ids=lambda card: card.stem)
def test_the_examples_of_a_card_use_columns_that_exist(card: Path) -> None:
    columns = {column for table in _card_columns(card).values() for column in table}
    text = card.read_text(encoding="utf-8")
    examples = re.findall(r"^```(?:python|sql)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    used = {name for example in examples for name in re.findall(r'"(\w+)"', example)}
    assert used
    other = {*_card_columns(card), card.stem, "units", "short", "variant1_coning"}  # tables, dataset, tier, case
    assert {name.removesuffix("_lo") for name in used} - other <= columns


@pytest.mark.parametrize("page", PAPERS, ids=lambda page: page.stem)
def test_the_modules_that_a_paper_page_names_exist(page: Path) -> None:
    modules = set(re.findall(r"`(sins(?:ref|data|bench)(?:\.\w+)+)`", page.read_text(encoding="utf-8")))
    assert modules
    assert {module for module in modules if find_spec(module) is None} == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_links_of_a_page_lead_to_files(page: Path) -> None:
    links = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    local = [link for link in links if "://" not in link]
    assert [link for link in local if not (page.parent / link).exists()] == []
