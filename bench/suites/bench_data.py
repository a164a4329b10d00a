"""Rows per second of the data package: generation, verification, reading of a tier's first case."""

from __future__ import annotations

from itertools import count
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from sinsdata.format.schema import DATASETS
from sinsdata.generation.generate import Generated, generate
from sinsdata.tiers import cases_of
from sinsdata.verification.verify import verify

#: Of a dataset the tier that is timed is the paper's, but of this one: its 900,000 rows take ten seconds to write.
TIERS = {"mast_antenna": "short"}


def _generated(dataset: str, folder: Path) -> Generated:
    tier = TIERS.get(dataset, "paper")
    return generate(dataset, tier, cases_of(dataset, tier)[:1], folder)


def _rows(made: Generated) -> int:
    return sum(entry["rows"] for entry in made.manifest["tables"].values())


def _record(benchmark: Any, rows: int) -> None:
    benchmark.extra_info["rows"] = rows
    benchmark.extra_info["rows_per_second"] = round(rows / benchmark.stats.stats.min)


@pytest.fixture(scope="module", params=list(DATASETS))
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Generated:
    dataset: str = request.param
    return _generated(dataset, tmp_path_factory.mktemp("data"))


@pytest.mark.parametrize("dataset", DATASETS)
def bench_generate(benchmark: Any, dataset: str, tmp_path: Path) -> None:
    """Rows of certified pairs, from the cases to a dataset on disk."""
    rounds = count()

    def fresh_folder() -> tuple[tuple[Any, ...], dict[str, Any]]:
        # A dataset that is there would be kept.
        return (dataset, tmp_path / str(next(rounds))), {}

    generated = benchmark.pedantic(_generated, setup=fresh_folder, rounds=5, iterations=1)
    _record(benchmark, _rows(generated))


def bench_verify(benchmark: Any, made: Generated) -> None:
    """Rows hashed twice, and three rows of each case and table computed again by mpmath."""
    checks = benchmark.pedantic(lambda: list(verify(made.folder)), rounds=5, iterations=1)
    assert all(check.holds for check in checks)
    _record(benchmark, _rows(made))


def bench_read(benchmark: Any, made: Generated) -> None:
    """Rows of all tables read by pyarrow."""
    tables = benchmark(lambda: [pq.read_table(path) for path in sorted(made.folder.glob("*.parquet"))])
    rows = sum(len(table) for table in tables)
    assert rows == _rows(made)
    _record(benchmark, rows)
