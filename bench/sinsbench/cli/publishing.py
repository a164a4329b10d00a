"""The commands that hand data on: publish, fetch, export."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sinsbench.cli.options import JsonFile

if TYPE_CHECKING:
    from sinsdata.publishing.fetch import Fetched


def _local_folder(text: str) -> Path:
    """Return the folder to write to; a URI would become a folder of that name."""
    if not text or "://" in text:
        raise typer.BadParameter(f"{text!r}: must be a local folder")
    return Path(text)


def publish(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A dataset, or a folder of datasets.")],
    out: Annotated[
        Path,
        typer.Option(parser=_local_folder, metavar="BUNDLE", help="Folder to write: new, empty, or an earlier bundle."),
    ],
    json: JsonFile = None,
) -> None:
    """Verify datasets and write them as a bundle: card, checksums, one archive a tier, registry."""
    from dataclasses import asdict

    from sinsbench.cli.output import Output
    from sinsdata.publishing.publish import NotSoundError
    from sinsdata.publishing.publish import publish as publish_datasets

    output = Output()
    output.check(json)
    try:
        with output.progress("publishing") as progress:
            made = publish_datasets(folder, out, progress=progress)
    except NotSoundError as error:
        rows = [asdict(check) for check in error.failed]
        output.json(json, rows)
        output.table(rows, title="does not hold", columns=("where", "what", "detail"))
        raise typer.Exit(1) from None
    entries = [{**vars(entry), "content_sha256": dict(entry.content_sha256)} for entry in made.registry.entries]
    output.json(json, entries)
    output.table(entries, title=str(made.folder), columns=("archive", "bytes", "sha256"))


def fetch(
    dataset: Annotated[str, typer.Argument(help="Such as equator_errors or dual_precession.")],
    tier: Annotated[str, typer.Option(help="Such as paper or standard.")] = "paper",
    mirror: Annotated[
        list[str] | None, typer.Option(metavar="URL", help="Ask this place first; may be repeated.")
    ] = None,
    source: Annotated[
        Path | None, typer.Option("--from", metavar="DIR", help="Take it from a bundle or a folder of archives.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(parser=_local_folder, metavar="DIR", help="Folder to write DATASET/TIER to, not to the cache."),
    ] = None,
    registry: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Registry of a bundle, in place of the package's own.")
    ] = None,
    generate: Annotated[bool, typer.Option("--generate", help="Generate it where it cannot be had.")] = False,
    json: JsonFile = None,
) -> None:
    """Get a published dataset: checked against the registry, cached; or generate the same content."""
    from sinsbench.cli.output import Output
    from sinsdata.publishing.fetch import UnavailableError, can_be_generated, generate_instead
    from sinsdata.publishing.fetch import fetch as fetch_dataset
    from sinsdata.publishing.registry import SHIPPED

    output = Output()
    output.check(json)
    known = registry or SHIPPED
    try:
        with output.progress(f"fetching {dataset}") as progress:
            got = fetch_dataset(
                dataset, tier, out=out, source=source, mirrors=mirror or (), registry=known, progress=progress
            )
    except UnavailableError as error:
        if not can_be_generated(dataset, tier):
            raise
        if not generate and not _agreed(str(error)):
            given = {"--tier": tier, "--out": out, "--registry": registry}
            options = "".join(f" {name} {value}" for name, value in given.items() if value is not None)
            raise UnavailableError(
                f"{error}. The same content can be generated: sinsbench fetch {dataset}{options} --generate"
            ) from None
        with output.progress(f"generating {dataset}") as progress:
            got = generate_instead(dataset, tier, out=out, registry=known, progress=progress)
    output.json(json, {"folder": str(got.folder), "origin": got.origin, "registered": got.entry is not None})
    output.line(f"{got.folder}: {_state(got)}")


def _state(got: Fetched) -> str:
    if got.entry is None:
        return f"{got.origin}; the registry has no such data to compare it with"
    from sinsdata.publishing.soundness import is_published

    if is_published(got.folder, got.entry):
        return f"{got.origin}; version {got.entry.version}, manifest and files are by their SHA-256 the published ones"
    return f"{got.origin}; version {got.entry.version}, content hashes, computed here, equal those of the registry"


def _agreed(reason: str) -> bool:
    """Ask whether to generate, where a person can answer."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return False
    typer.echo(reason, err=True)
    return typer.confirm("Generate the same content here?", err=True)


def export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A dataset, or a folder of datasets.")],
    out: Annotated[Path, typer.Option(parser=_local_folder, metavar="DIR", help="To write DATASET/TIER/*.csv to.")],
    json: JsonFile = None,
) -> None:
    """Write datasets as plain CSV; the numbers read back exactly."""
    from sinsbench.cli.output import Output
    from sinsdata.publishing.csv_export import export_csv
    from sinsdata.verification.stored_cases import find_datasets

    output = Output()
    output.check(json)
    rows = []
    with output.progress("exporting") as progress:
        folders = find_datasets(folder)
        for number, found in enumerate(folders):
            progress(number, len(folders), str(found))
            rows += [{"dataset": str(found), "file": name, "rows": n} for name, n in export_csv(found, out).items()]
    output.json(json, rows)
    output.table(rows, title=str(out))
