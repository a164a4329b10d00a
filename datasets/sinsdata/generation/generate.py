"""Generation of a dataset: cases to certified tables, Parquet files and a manifest."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from time import sleep
from typing import Any, TypeAlias

from sinsdata.cases import Case
from sinsdata.format import manifest
from sinsdata.format.content_hash import combined
from sinsdata.format.croissant import croissant_text
from sinsdata.format.manifest import DatasetError
from sinsdata.format.schema import arrow_schema
from sinsdata.format.storage import text_entry
from sinsdata.generation import digits
from sinsdata.generation.destination import Destination, Place, destination, shown
from sinsdata.generation.shards import ShardReceipt, complete
from sinsdata.generation.specification import Specification
from sinsdata.generation.workers import Results, check_workers, cluster, here, pool
from sinsref.rounding import RoundingTally

#: Times that files of this run may vanish before that is an error.
_LOSSES = 5
#: ``progress(rows done, rows in all, what)``.
Progress: TypeAlias = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Generated:
    """What `generate` wrote.

    Attributes
    ----------
    folder : Path or str
        The dataset: a path, or a URI, without credentials and options, where one was given.
    manifest : dict
        Its manifest; empty while shards of other jobs are missing.
    shards, reused, missing : int
        Files in all; those that an earlier run had finished; those that other jobs have not finished yet.
    """

    folder: Any
    manifest: dict[str, Any]
    shards: int = 0
    reused: int = 0
    missing: int = 0


def _silent(done: int, total: int, what: str) -> None:
    pass


def generate(
    dataset: str,
    tier: str,
    cases: Sequence[Case],
    out: Place,
    progress: Progress = _silent,
    *,
    tables: Sequence[str] | None = None,
    workers: int = 1,
    part: tuple[int, int] | None = None,
    scheduler: str | None = None,
) -> Generated:
    """Write a dataset to ``out/dataset/tier``, in place of one that is there.

    A run that is interrupted, or killed, leaves the files that it has finished; the same call goes on from there. The
    content does not depend on who computes it. Runs of the same specification at the same time share what they finish;
    of runs of different ones the last to finish stays.

    Parameters
    ----------
    dataset, tier : str
    cases : sequence of Case
        May build its cases as they are asked for.
    out : Path or str
        A folder, or a URI that `pyarrow.fs` knows, such as ``s3://bucket/folder``.
    progress : callable, optional
        Called with rows done, rows in all, and what is at work.
    tables : sequence of str, optional
        All by default.
    workers : int, default 1
        Processes; with 1 everything happens in this one.
    part : tuple of int, optional
        ``(i, n)``: only each n-th shard, beginning with the i-th, from 1: one of n independent jobs. The job that
        finds all others' shards finished completes the dataset.
    scheduler : str, optional
        Address of a Dask scheduler, in place of `workers`.

    Returns
    -------
    Generated

    Raises
    ------
    sinsdata.generation.tables.UnknownTableError
        For a table that the dataset does not have.
    sinsdata.generation.workers.WorkerError
        If workers are lost, or both `workers` and a scheduler are asked for, or its address is not one.
    sinsdata.format.manifest.DatasetError
        If the place cannot be used.
    """
    if not str(out):
        raise DatasetError("--out names no folder: it is empty")
    check_workers(workers, scheduler)
    progress(0, 0, "looking at the cases")
    specification = Specification(dataset, tier, cases, None if tables is None else tuple(tables))
    place = destination(out, dataset, tier, specification.key)
    folder = shown(out, dataset, tier)
    files = sum(len(shard.files) for shard in specification.shards)
    losses = 0
    while True:
        there = place.finished()
        if there is not None and there["specification"] == specification.key and place.intact(there):
            place.tidy()
            return Generated(folder, there, files, reused=files)
        place.begin()
        try:
            receipts = _receipts(specification, place, progress, workers, part, scheduler)
            if len(receipts) == len(specification.shards):
                made = _finish(specification, place, receipts)
                break
            finished = place.receipts()
            missing = sum(len(shard.files) for shard in specification.shards if shard.receipt not in finished)
            if missing and not place.taken():
                return Generated(folder, {}, files, missing=missing)
        except FileNotFoundError:
            # Another run of this specification has finished and taken the folder along; a third may have made it anew.
            losses += 1
            if losses > _LOSSES:
                raise
            sleep(0.05 * losses)
        finally:
            place.leave()
    progress(specification.all_rows, specification.all_rows, "done")
    return Generated(folder, made, files, sum(len(names) for names, receipt in receipts.items() if receipt.reused))


def _receipts(
    specification: Specification,
    place: Destination,
    progress: Progress,
    workers: int,
    part: tuple[int, int] | None,
    scheduler: str | None,
) -> dict[tuple[str, ...], ShardReceipt]:
    """Compute shards and return receipts by file names: all, or fewer while other jobs have not finished theirs."""
    first, step = part or (1, 1)
    own = (specification.task(shard) for shard in specification.shards[first - 1 :: step])
    done, total = 0, specification.all_rows

    def report(rows: int) -> None:
        nonlocal done
        done += rows
        progress(done, total, "rows")

    progress(0, total, "rows")
    results: Results
    if scheduler is not None:
        results = cluster(own, place, report, scheduler)
    elif workers > 1:
        results = pool(own, place, report, workers)
    else:
        results = here(own, place, report)
    receipts = {task.files: receipt for task, receipt in results}
    if part is not None:
        others = [shard for shard in specification.shards if shard.files not in receipts]
        if place.receipts().issuperset(shard.receipt for shard in others):
            receipts |= {shard.files: complete(specification.task(shard), place, report) for shard in others}
    return receipts


def _finish(
    specification: Specification, place: Destination, receipts: dict[tuple[str, ...], ShardReceipt]
) -> dict[str, Any]:
    tally = RoundingTally()
    pages: dict[str, list[bytes]] = {}
    tables: dict[str, dict[str, Any]] = {}
    for shard in specification.shards:
        receipt = receipts[shard.files]
        tally = replace(tally, **{k: v + getattr(tally, k) for k, v in asdict(receipt.tally).items()})
        for file in receipt.files:
            entry = tables.setdefault(file.table, {"rows": 0, "content_sha256": "", "files": []})
            entry["rows"] += file.rows
            entry["files"].append({"file": file.file, "rows": file.rows, "bytes": file.size, "sha256": file.sha256})
            pages.setdefault(file.table, []).append(file.pages)
    for table, entry in tables.items():
        entry["content_sha256"] = combined(arrow_schema(specification.dataset, table), pages[table])
    about = manifest.compose(
        specification.dataset, specification.tier, specification.key, len(specification.cases), tables, tally
    )
    texts = {digits.NAME: digits.digits_text(specification)}
    texts["croissant.json"] = croissant_text(about)
    text = manifest.sealed(about, [text_entry(name, content) for name, content in texts.items()])
    texts[manifest.NAME] = text
    place.finish(texts, [name for shard in specification.shards for name in shard.files])
    made: dict[str, Any] = json.loads(text)
    return made
