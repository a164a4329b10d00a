"""The page: all of it inside, every series and every claim there, tables that a screen reader can read."""

import base64
import csv
import gzip
import io
import json
import re
from html.parser import HTMLParser

import pytest

from report_results import CASE, CLAIMS, PRECESSION
from sinsbench.report import page as pages
from sinsbench.report.results import Results
from sinsbench.report.sections import sections


class Page(HTMLParser):
    """Elements with their attributes, texts of cells, contents of scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.cells: list[list[str]] = []
        self.scripts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag == "tr":
            self.cells.append([])
        elif tag in ("td", "th") and self.cells:
            self.cells[-1].append("")
        elif tag == "script":
            self.scripts.append("")

    def handle_data(self, data):
        if self.elements and self.elements[-1][0] == "script":
            self.scripts[-1] += data
        elif self.cells and self.cells[-1]:
            self.cells[-1][-1] += data

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.elements if name == tag]


@pytest.fixture(scope="module")
def made(results, parts) -> pages.Page:
    return pages.page(results, parts)


@pytest.fixture(scope="module")
def parsed(made) -> Page:
    return Page(made.html)


def test_nothing_lies_elsewhere(made, parsed: Page) -> None:
    addresses = [
        attributes[name]
        for _, attributes in parsed.elements
        for name in ("src", "href", "action", "data", "poster", "srcset", "content")
        if attributes.get(name)
    ]
    assert not [x for x in addresses if x and re.match(r"(?i)(https?:)?//", x)]
    own = made.html.replace(pages.libraries(), "")
    assert not re.search(r"https?://|@import|url\(", own)
    assert "default-src 'none'" in own
    assert "data:application/gzip" in own


def test_it_is_small_and_the_same_twice(made, results) -> None:
    # The whole of the libraries, and room for the scores of every method on several cases.
    assert len(made.html.encode()) < 2_000_000
    assert pages.page(results, sections(results)) == made
    assert made.beside == {}


def test_every_series_is_in_the_legend_and_in_the_data(parsed: Page) -> None:
    charts = json.loads(next(text for text in parsed.scripts if text.startswith('{"charts"')))
    data = charts["data"]["scores_dual_precession"]
    place = data["columns"].index("subject")
    assert {row[place] for row in data["rows"]} == set(PRECESSION)
    buttons = [attributes.get("data-series") for attributes in parsed.all("button")]
    for name in PRECESSION:
        # Work, orders, secular parts, error over time.
        assert buttons.count(name) == 4
    figures = {x["id"] for x in parsed.all("div") if (x.get("class") or "") == "chart"}
    assert figures == {f"chart-{name}" for name in charts["charts"]}
    assert {"chart-work_precision_attitude_operations", "chart-ladder_secular", "chart-growth_attitude_error",
            "chart-parts_velocity", "chart-stability_growth", "chart-claims", "chart-mutants",
            "chart-timings"} <= figures  # fmt: skip


def test_every_claim_stands_beside_its_recomputed_number(parsed: Page) -> None:
    rows = {row[0]: [cell.strip() for cell in row] for row in parsed.cells if row and row[0].startswith("lebedev1989 ")}
    for claim in CLAIMS:
        row = rows[f"lebedev1989 {claim['id']}"]
        assert claim["printed"] in row
        assert claim["verdict"] in row
        computed = claim["computed"]
        assert (f"{computed:.6g}" if isinstance(computed, float) else computed) in row


def test_tables_have_captions_scopes_and_sorting(parsed: Page) -> None:
    tables = len(parsed.all("table"))
    assert tables > 10
    assert len(parsed.all("caption")) == tables
    heads = [attributes for attributes in parsed.all("th") if attributes.get("scope") == "col"]
    assert heads
    assert all(attributes.get("aria-sort") == "none" for attributes in heads)
    assert all(attributes.get("scope") for attributes in parsed.all("th"))
    assert all(x.get("aria-label") for x in parsed.all("div") if x.get("role") in ("img", "region"))


def test_every_link_inside_leads_somewhere(parsed: Page) -> None:
    names = {attributes.get("id") for _, attributes in parsed.elements}
    inside = {x["href"].removeprefix("#") for x in parsed.all("a") if (x.get("href") or "").startswith("#")}
    assert len(inside) > 10
    assert inside <= names
    ids = [attributes["id"] for _, attributes in parsed.elements if attributes.get("id")]
    assert len(ids) == len(set(ids))


def test_the_files_hold_the_results_with_all_their_digits(parsed: Page, scores) -> None:
    files = {
        x["download"]: gzip.decompress(base64.b64decode((x["href"] or "").partition(",")[2])).decode()
        for x in parsed.all("a")
        if x.get("download")
    }
    assert json.loads(files["scores.json.gz"]) == scores
    for row, line in zip(scores, csv.DictReader(io.StringIO(files["scores.csv.gz"], newline="")), strict=True):
        assert line["case"] == row["case"]
        error = row["attitude_error_max"]
        assert line["attitude_error_max"] == ("" if error is None else repr(error))


def test_what_does_not_fit_is_written_beside(results, parts, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "_MOST_BYTES", 0)
    small = pages.page(results, parts)
    assert json.loads(small.beside["data/claims.json"]) == CLAIMS
    assert 'href="data/claims.json"' in small.html


def test_sections_without_results_are_absent(results) -> None:
    alone = Results(claims=results.claims)
    text = pages.page(alone, sections(alone)).html
    assert 'id="claims"' in text
    for name in ("work_precision", "ladders", "mutants", "timings", "data", "equator", "gyroscopic", "secular"):
        assert f'<section id="{name}"' not in text
    assert "Leaderboard" not in text


def test_the_first_screen_tells_what_holds(made) -> None:
    listed = re.findall(r'<li class="(good|bad)"><strong>(.*?)</strong>', made.html)
    assert {what: verdict for verdict, what in listed} == {
        "Truth of the papers&#39; cases": "good",
        "Datasets on disk": "bad",  # a check fails
        "Scores on dual_precession": "good",
        "Scores on equator_errors": "good",
        "What the papers print": "bad",  # these verdicts are not on record
        "Defects planted in the methods": "bad",  # one survives
        "Stored timings": "bad",  # half as long again
    }


def test_a_name_cannot_break_out_of_the_page(results, parts) -> None:
    name = "</script><script>alert(1)</script>"
    row = {**results.scores[0], "subject": name}
    evil = Results(scores=[row])
    text = pages.page(evil, sections(evil)).html
    assert name not in text
    assert len(Page(text).all("script")) == 3


def test_the_case_to_choose_is_the_one_that_was_scored(parsed: Page) -> None:
    cases = {x["data-case"] for x in parsed.all("section") if x.get("data-case")}
    assert cases == {CASE}
