"""The page in headless Chromium with the network cut: run by ``tox -e page``, not collected by pytest.

Opens a page, or one made of two methods, in both themes at 400 and 1600 px: no request, no error on the console, every
chart drawn; tables sort and filter, the legend hides series, the theme switches, cases change. Pictures are written to
the folder that is named, for people to judge.

    python browser.py PICTURES [PAGE]

Needs playwright, and Chromium: ``chromium``, ``chromium-browser`` or ``google-chrome`` on the path, or ``CHROMIUM``.
"""

import os
import shutil
import sys
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright

from sinsbench.cli import run

WIDTHS, THEMES = (1600, 400), ("light", "dark")
#: Seconds of processor time in which a page must be open; the clock counts other programs of the machine too.
SLOWEST = 1.0
DRAWN = "document.querySelectorAll('.chart svg.marks').length === document.querySelectorAll('.chart').length"
OPENED = "performance.getEntriesByType('navigation')[0].loadEventEnd"


def made(folder: Path) -> Path:
    """Return a page of two methods."""
    scores = folder / "scores.json"
    cases = ["--case", "variant2_coning", "--case", "variant2_general"]
    assert run(["score", "panov2", "panov4", "--on", "dual_precession", *cases, "--json", str(scores)]) == 0
    assert run(["report", str(scores), "--out", str(folder)]) == 0
    return folder / "report.html"


def check_tables(page: Page) -> None:
    """Sort by the first column of numbers, up and down, and filter."""
    table = page.locator("table").first
    place = next(n for n, head in enumerate(table.locator("thead th").all()) if head.get_attribute("class") == "n")
    head = table.locator("thead th").nth(place)
    for direction, sign in (("ascending", 1), ("descending", -1)):
        head.locator("button").click()
        assert head.get_attribute("aria-sort") == direction
        cells = table.locator(f"tbody tr td:nth-child({place + 1})")
        keys = [float(key) for cell in cells.all() if (key := cell.get_attribute("data-key"))]
        assert keys == sorted(keys, key=lambda key: sign * key)
    for box in page.locator(".filter input").all()[:1]:
        rows = page.locator(f"#{box.get_attribute('aria-controls')} tr:visible")
        before = rows.count()
        box.fill("no such words anywhere")
        assert rows.count() == 0
        box.fill("")
        assert rows.count() == before


def check_legend(page: Page) -> None:
    """Hide a series and show it again: its marks go and come."""
    section = page.locator("section:has(.legend)").first
    chart, button = section.locator(".chart").first, section.locator(".legend button").first
    marks = chart.locator("path[aria-roledescription='point'], .mark-symbol path, .mark-line path")
    before = marks.count()
    assert before
    for pressed in ("false", "true"):
        button.press("Enter")
        assert button.get_attribute("aria-pressed") == pressed
        page.wait_for_timeout(300)
        assert (marks.count() < before) == (pressed == "false")
    choice = section.locator("select.case")
    if choice.is_enabled():
        drawn = chart.inner_html()
        choice.select_option(index=1)
        page.wait_for_timeout(300)
        assert chart.inner_html() != drawn


def check(browser: Any, path: Path, width: int, theme: str, pictures: Path) -> None:
    """Open the page at a width and in a theme, try everything, and take pictures of it."""
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=theme, offline=True)
    page = context.new_page()
    said: list[str] = []
    asked: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    session = context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})
    page.goto(path.resolve().as_uri())
    metrics = {one["name"]: one["value"] for one in session.send("Performance.getMetrics")["metrics"]}
    seconds = page.evaluate(OPENED) / 1000
    page.wait_for_function(DRAWN, timeout=60_000)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), "wider than the window"
    assert page.evaluate("document.documentElement.dataset.theme") == theme
    page.screenshot(path=pictures / f"{width}_{theme}.png")
    page.evaluate("document.querySelector('header').style.position = 'static'")
    # A section that is laid out only when it comes near would move the ones below it while they are taken.
    page.add_style_tag(content="main > section { content-visibility: visible !important; }")
    for section in page.locator("main > section").all():
        section.screenshot(path=pictures / f"{width}_{theme}_{section.get_attribute('id')}.png")
    check_tables(page)
    if page.locator(".legend").count():
        check_legend(page)
    page.locator("#theme").click()
    assert page.evaluate("document.documentElement.dataset.theme") != theme
    page.wait_for_function(DRAWN, timeout=60_000)
    assert said == [], said
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
    assert metrics["TaskDuration"] < SLOWEST, f"{metrics['TaskDuration']:.2f} s of processor time to open"
    context.close()
    taken = f"open after {seconds:.2f} s ({metrics['TaskDuration']:.2f} s of processor time)"
    print(f"{width} px, {theme}: {taken}, no request, no word on the console")


def main(pictures: Path, path: Path | None) -> None:
    """Check a page at all widths and in both themes."""
    found = (os.environ.get("CHROMIUM"), *map(shutil.which, ("chromium", "chromium-browser", "google-chrome")))
    program = next((one for one in found if one), None)
    if program is None:
        sys.exit("browser.py: there is no Chromium on the path; install one, or name it in CHROMIUM")
    pictures.mkdir(parents=True, exist_ok=True)
    chosen = path or made(pictures)
    with sync_playwright() as playwright:
        # Root, as in containers, has no sandbox.
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        for width in WIDTHS:
            for theme in THEMES:
                check(browser, chosen, width, theme, pictures)
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
