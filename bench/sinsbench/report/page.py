"""The page: sections filled into a template, with everything it needs inside."""

from __future__ import annotations

import base64
import csv
import gzip
import io
import json
from collections.abc import Mapping, Sequence
from functools import cache, partial
from importlib import resources
from typing import Any, NamedTuple

from sinsbench import __version__
from sinsbench.cli.output import cell, heading, number
from sinsbench.report.boards import boards, own_interval
from sinsbench.report.findings import checks
from sinsbench.report.model import Section
from sinsbench.report.results import Results, Row
from sinsbench.report.style import style_of

__all__ = ["Page", "csv_text", "json_text", "libraries", "page", "without_legend"]

#: Bytes of a page, at most, its tables and charts apart; files for download that do not fit are written beside it.
_MOST_BYTES = 2_950_000
_AROUND = 300  # bytes of a link and of what refers to it
_ENTRY = "window.vegaEmbed = vegaEmbed;"


def json_text(rows: Sequence[Row]) -> str:
    """Return rows as JSON, as the commands write it but for the spaces."""
    return json.dumps(list(rows), ensure_ascii=False, separators=(",", ":")) + "\n"


def csv_text(rows: Sequence[Row]) -> str:
    """Return rows as CSV (RFC 4180): every field that a row has, numbers with all their digits, nothing for None."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(names)
    writer.writerows([_plain(row.get(name)) for name in names] for row in rows)
    return text.getvalue()


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, ensure_ascii=False) if isinstance(value, list | dict | bool) else value


_KINDS = {"csv": csv_text, "json": json_text}


@cache
def libraries() -> str:
    """Return Vega, Vega-Lite and vega-embed as one script, as vl-convert carries them."""
    import altair as alt
    import vl_convert

    major, minor = alt.SCHEMA_VERSION.removeprefix("v").split(".")[:2]
    script: str = vl_convert.javascript_bundle(_ENTRY, vl_version=f"{major}.{minor}")
    return script.replace("</script", "<\\/script")


class Page(NamedTuple):
    """A page, and files that it links to because they have no room in it, by their paths beside it."""

    html: str
    beside: Mapping[str, str]


def page(results: Results, sections: Sequence[Section]) -> Page:
    """Return the page of results.

    Parameters
    ----------
    results : Results
        For the first screen.
    sections : sequence of Section
        What follows it.

    Returns
    -------
    Page
        The same for the same results and versions.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("sinsbench.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    environment.filters |= {"heading": heading, "shown": _shown, "key": _key, "numeric": _numeric}
    folder = resources.files("sinsbench.report") / "templates"
    style, script = ((folder / name).read_text(encoding="utf-8") for name in ("page.css", "page.js"))
    render = partial(
        environment.get_template("page.html").render,
        version=__version__,
        checks=checks(results),
        boards=boards(own_interval(results.scores)),
        sections=sections,
        style_of=style_of,
        style=style,
        script=script,
        libraries=libraries() if any(section.charts for section in sections) else "",
        charts=_embedded(sections),
    )
    links, beside = _links(sections, _MOST_BYTES - len(render(links={}).encode()))
    return Page(render(links=links), beside)


def _embedded(sections: Sequence[Section]) -> str:
    """Return specifications and data of all charts as JSON that may stand in a script element."""
    data = {name: _columns(rows) for section in sections for name, rows in section.data.items()}
    charts = {
        chart.name: {"specification": without_legend(chart.specification), "data": chart.data}
        for section in sections
        for chart in section.charts
    }
    text = json.dumps({"charts": charts, "data": data}, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def without_legend(part: Any) -> Any:
    """Return a specification without the legend of its series: the page has one that hides and shows them."""
    if isinstance(part, list | tuple):
        return [without_legend(one) for one in part]
    if not isinstance(part, Mapping):
        return part
    legend = {"legend": None} if part.get("field") == "subject" and "legend" in part else {}
    return {name: without_legend(one) for name, one in part.items()} | legend


def _columns(rows: Sequence[Row]) -> dict[str, Any]:
    """Return rows with the names of their fields once, a third of the size."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return {"columns": names, "rows": [[row.get(name) for name in names] for row in rows]}


def _links(sections: Sequence[Section], room: int) -> tuple[dict[str, dict[str, str]], dict[str, str]]:
    """Return addresses of files for download, by name and kind, and the files that have no room in the page.

    Small ones come first, packed by gzip into their addresses.
    """
    files = {name: rows for section in sections for name, rows in section.files.items()}
    links: dict[str, dict[str, str]] = {name: {} for name in files}
    texts = {(name, kind): text(rows) for kind, text in _KINDS.items() for name, rows in files.items()}
    packed = {key: base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode() for key, text in texts.items()}
    beside = {}
    for (name, kind), content in sorted(packed.items(), key=lambda item: len(item[1])):
        room -= len(content) + _AROUND
        if room > 0:
            links[name][kind] = f"data:application/gzip;base64,{content}"
        else:
            links[name][kind] = path = f"data/{name}.{kind}"
            beside[path] = texts[name, kind]
    return links, beside


def _shown(value: Any) -> str:
    """Return a value as people read it; a whole number that is a float without decimals."""
    if isinstance(value, float):
        return f"{value:.0f}" if value.is_integer() and abs(value) < 1e6 else number(value)
    return cell(value)


def _numeric(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _key(value: Any) -> str:
    """Return what a value is sorted by: a number with more digits than are shown."""
    return f"{value:.7g}" if _numeric(value) else ""
