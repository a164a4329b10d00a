"""The sections of a report that judge: claims, planted defects, checks of the data, timings; and the first screen."""

from __future__ import annotations

import platform
from collections import Counter
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from sinsbench.claims.model import PAPERS
from sinsbench.cli.claims import changed_verdicts, claim_table, verdict_counts
from sinsbench.dashboard import compared, standing_regressions
from sinsbench.report import mast, others
from sinsbench.report.model import Check, Section, Table
from sinsbench.report.results import Results, Row, real

__all__ = ["checks", "sections"]

_TIMING_COLUMNS = {
    "benchmark": "benchmark",
    "run": "run",
    "commit": "commit",
    "minimum, s": "minimum",
    "median, s": "median",
    "rounds": "rounds",
    "minimum / before": "ratio_minimum",
    "median / before": "ratio_median",
    "p": "p_value",
    "verdict": "verdict",
}
_PACKAGES = ("sinsbench", "numpy", "scipy", "numba", "pyarrow", "python-flint", "altair", "vl-convert-python")
_COMMIT = 10  # hexadecimal digits that people read


def counted(number: int, noun: str) -> str:
    """Return a number of things: 1 case, 2 cases."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def checks(results: Results) -> list[Check]:
    """Return the lines of the first screen: what was checked, and what of it holds."""
    return [*_of_data(results), *_of_scores(results), *_of_claims(results), *_of_mutants(results), *_of_runs(results)]


def _of_data(results: Results) -> Iterator[Check]:
    if results.datasets:
        held, failed = (
            int(sum(real(row, f"checks that {verb}") or 0 for row in results.datasets)) for verb in ("hold", "fail")
        )
        values = int(sum(real(row, "values") or 0 for row in results.datasets))
        found = f"{counted(values, 'value')} proved; checks: {held:,} hold, {failed:,} fail"
        yield Check("Truth of the papers' cases", found, failed == 0, "data")
    if results.checks:
        failed = sum(not row["holds"] for row in results.checks)
        held = len(results.checks) - failed
        yield Check("Datasets on disk", f"checks: {held:,} hold, {failed:,} fail", failed == 0, "data")


def _of_scores(results: Results) -> Iterator[Check]:
    names = {"dual_precession": "work_precision", "equator_errors": "equator", "gyro_systems": "gyroscopic"}
    names[mast.DATASET] = mast.NAME
    for dataset in dict.fromkeys(row["dataset"] for row in results.scores):
        rows = [row for row in results.scores if row["dataset"] == dataset]
        broken = [row for row in rows if row["status"] not in ("ok", "not applicable")]
        subjects, cases = ({row[key] for row in rows} for key in ("subject", "case"))
        runs = counted(len(rows), "run")
        found = f"{counted(len(subjects), 'method')} on {counted(len(cases), 'case')}, {runs}; {len(broken):,} failed"
        section = names.get(dataset, f"scores_{dataset}")
        yield Check(
            f"Scores on {dataset}", found, not broken, "failures" if broken else section, ("all ran", "failures")
        )


def _of_claims(results: Results) -> Iterator[Check]:
    if results.claims:
        counts = Counter(row["verdict"] for row in results.claims)
        changed = changed_verdicts([row for row in results.claims if row["paper"] in PAPERS])
        found = (
            f"{len(results.claims)}: {counts['reproduced']} reproduced, {counted(counts['misprint'], 'misprint')} "
            f"explained, {counts['not reproduced']} not reproduced"
        )
        words = ("verdicts as on record", f"{counted(len(changed), 'verdict')} not as on record")
        yield Check("What the papers print", found, not changed, "claims", words)


def _of_mutants(results: Results) -> Iterator[Check]:
    if results.mutants:
        counts = Counter(row["verdict"] for row in results.mutants)
        found = (
            f"{len(results.mutants):,}: {counts['told apart']:,} told apart, {counts['equivalent']:,} make no "
            f"difference for a reason, {counts['unexplained']:,} for none known, {counts['survivor']:,} survive"
        )
        yield Check(
            "Defects planted in the methods", found, not counts["survivor"], "mutants", ("none survives", "survivors")
        )


def _of_runs(results: Results) -> Iterator[Check]:
    if results.runs:
        standing = standing_regressions(compared(results.runs))
        commits = ", ".join(dict.fromkeys(str(row["commit"])[:_COMMIT] or str(row["run"]) for row in standing))
        found = f"{counted(len(results.runs), 'run')}; {counted(len(standing), 'benchmark')} slower than before"
        found += f" ({commits})" if commits else ""
        yield Check("Stored timings", found, not standing, "timings", ("none slower", "slower"))


def sections(results: Results) -> Iterator[Section]:
    """Yield the sections about claims, planted defects, timings, data, machine and versions."""
    yield from _failures(results)
    yield from _claims(results)
    yield from _mutants(results)
    yield from _timings(results)
    yield from _data(results)
    yield _machine(results)


def _failures(results: Results) -> Iterator[Section]:
    rows = [
        {name: row.get(name) for name in ("subject", "dataset", "case", "interval", "status", "message")}
        for row in results.scores
        if row["status"] != "ok"
    ]
    if rows:
        yield Section(
            "failures",
            "What did not run",
            "Failures",
            "Methods that failed on a case, or declined it, at a sampling interval.",
            tables=(Table("failures", "Status and message", rows),),
            files={"scores": results.scores},
        )


def _claims(results: Results) -> Iterator[Section]:
    if results.claims:
        rows = [
            {
                "claim": f"{row['paper']} {row['id']}",
                "place": row.get("where"),
                "quantity": row.get("quantity"),
                "printed": row["printed"],
                "recomputed": told["computed"],
                "unit": row.get("unit"),
                "difference": real(row, "relative_difference"),
                "verdict": row["verdict"],
                "note": row.get("note"),
            }
            for row, told in zip(results.claims, claim_table(results.claims, None), strict=True)
        ]
        points = [
            {**row, "place": _place(row), "difference": float(f"{abs(row['difference']):.4g}")}
            for row in rows
            if row["difference"]
        ]
        for point in points:
            del point["note"]
        yield Section(
            "claims",
            "Claims: printed beside recomputed",
            "Claims",
            "Every number that the papers print is recomputed. A misprint is a number that a named and tested slip "
            "explains; the difference is relative to the recomputed value.",
            tables=(
                Table("claim_counts", "Verdicts by paper", verdict_counts(results.claims)),
                Table("claims", "Every claim", rows),
                *(
                    Table(f"story_{n}", str(story["title"]), story["rows"], str(story["sentence"]))
                    for n, story in enumerate(_stories(results))
                ),
            ),
            charts=(others.claim_chart("claims", len({point["place"] for point in points})),) if points else (),
            data={"claims": points} if points else {},
            files={"claims": results.claims},
        )


def _place(row: Row) -> str:
    """Return paper and place of a claim; the rows of a table are one place."""
    return f"{row['claim'].split()[0]}, {str(row['place']).partition(', row')[0]}"


def _stories(results: Results) -> list[Row]:
    return [story for story in results.stories if isinstance(story["rows"], list) and story["rows"]]


def _mutants(results: Results) -> Iterator[Section]:
    if not results.mutants:
        return
    subjects = tuple(dict.fromkeys(row["subject"] for row in results.mutants))
    counts = Counter((row["subject"], row["verdict"]) for row in results.mutants)
    bars = [
        {"subject": subject, "verdict": verdict, "defects": counts[subject, verdict], "order": order}
        for subject in subjects
        for order, verdict in enumerate(others.MUTANT_VERDICTS)
        if counts[subject, verdict]
    ]
    table = [
        {"subject": subject, "planted": sum(counts[subject, verdict] for verdict in others.MUTANT_VERDICTS)}
        | {verdict: counts[subject, verdict] for verdict in others.MUTANT_VERDICTS}
        for subject in subjects
    ]
    order = ("survivor", "unexplained", "equivalent")
    unseen = sorted(
        (row for row in results.mutants if row["verdict"] in order), key=lambda row: order.index(row["verdict"])
    )
    rows = [{name: row.get(name) for name in ("verdict", "subject", "kind", "defect", "reason")} for row in unseen]
    survivors = sum(row["verdict"] == "survivor" for row in unseen)
    yield Section(
        "mutants",
        "Planted defects and survivors",
        "Defects",
        "A defect is planted in each coefficient and term of a method; the score must tell the result apart. "
        + ("No defect that changes results survives." if not survivors else f"{survivors} survive."),
        tables=(
            Table("mutant_counts", "Defects by method", table),
            *([Table("unseen_mutants", "Defects that the score does not see, with the reason", rows)] if rows else []),
        ),
        charts=(others.mutant_chart("mutants", len(subjects)),),
        data={"mutants": bars},
        files={"mutants": results.mutants},
    )


def _timings(results: Results) -> Iterator[Section]:
    rows = compared(results.runs)
    if not rows:
        return
    firsts: dict[tuple[str, str], float] = {}
    points = []
    for row in rows:
        taken = row["minimum"] / (row["calibration_ns"] or 1.0)
        first = firsts.setdefault((row["machine"], row["benchmark"]), taken)
        kept = ("benchmark", "run", "machine", "verdict")
        points.append(
            {name: row[name] for name in kept}
            | {"benchmark": _name(row), "commit": row["commit"][:_COMMIT]}
            | {"relative": float(f"{taken / first:.5g}")}
        )
    table = [
        {heading: row[field] for heading, field in _TIMING_COLUMNS.items()}
        | {"benchmark": _name(row), "commit": row["commit"][:_COMMIT] + "+" * bool(row["dirty"])}
        for row in rows
    ]
    slower = [row for row in table if row["verdict"] == "slower"]
    several = len({row["run"] for row in rows}) > 1
    yield Section(
        "timings",
        "Timing history",
        "Timings",
        "Stored runs of the benchmarks, compared on equal machines only, by minimum and median: slower is what takes "
        "1.1 times as long by both and is told apart by the test of Mann and Whitney. A commit with + was changed.",
        tables=(
            *([Table("regressions", "Slower than before", slower)] if slower else []),
            Table("timings", "All timings", table),
        ),
        charts=(others.timing_chart("timings"),) if several else (),
        data={"timings": points} if several else {},
        files={"timings": rows},
    )


def _name(row: Row) -> str:
    """Return the name of a benchmark without the folder of its file."""
    return str(row["benchmark"]).rpartition("/")[2]


def _data(results: Results) -> Iterator[Section]:
    tables, files = [], {}
    if results.datasets:
        tables.append(Table("datasets", "Generated, proved, verified", results.datasets))
        files["datasets"] = results.datasets
    if results.checks:
        failed = [row for row in results.checks if not row["holds"]]
        counts = Counter(str(row["where"]) for row in results.checks)
        broken = Counter(str(row["where"]) for row in failed)
        rows = [{"where": where, "checks": counts[where], "that fail": broken[where]} for where in counts]
        tables += [Table("checks", "Checks of datasets on disk", rows)]
        tables += [Table("failed_checks", "Does not hold", failed)] if failed else []
        files["checks"] = results.checks
    if tables:
        yield Section("data", "Truth and datasets", "Data", tables=tuple(tables), files=files)


def _machine(results: Results) -> Section:
    rows: list[dict[str, Any]] = [
        {"of": "this page", "what": name, "value": value} for name, value in _environment().items()
    ]
    rows += [{"of": "the reproduction", "what": name, "value": value} for name, value in results.environment.items()]
    for run in results.runs:
        commit = f"commit {run.commit[:_COMMIT]}" if run.commit else "no commit"
        named = {"machine": run.machine, "made": f"{run.time}, {commit}{', changed' if run.dirty else ''}"}
        rows += [{"of": run.file, "what": name, "value": value} for name, value in (named | dict(run.versions)).items()]
    table = Table("machine", "What everything was made with", rows)
    return Section("machine", "Machine and versions", "Machine", tables=(table,))


def _environment() -> dict[str, str]:
    found = {"python": platform.python_version(), "machine": platform.machine(), "system": platform.system()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
