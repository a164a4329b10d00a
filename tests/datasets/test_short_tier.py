"""The tier that comes with the package: sound, and what the present code generates."""

from pathlib import Path
from typing import Any

import pytest

import sinsdata
from sinsdata.cases import CASE_CLASSES
from sinsdata.generation.generate import generate
from sinsdata.tiers import short_cases
from sinsdata.verification.verify import verify


def contents(manifest: dict[str, Any]) -> dict[str, str]:
    return {table: entry["content_sha256"] for table, entry in manifest["tables"].items()}


@pytest.mark.parametrize("dataset", CASE_CLASSES)
def test_it_verifies_and_is_what_is_generated(dataset: str, tmp_path: Path) -> None:
    shipped = sinsdata.load(dataset, "short")
    assert [check for check in verify(shipped.folder) if not check.holds] == []
    made = generate(dataset, "short", short_cases(dataset), tmp_path)
    assert contents(made.manifest) == contents(shipped.manifest)
    # Text is the same to the byte; Parquet files only where the library is.
    assert (made.folder / "digits.csv").read_bytes() == (shipped.folder / "digits.csv").read_bytes()


@pytest.mark.parametrize("dataset", CASE_CLASSES)
def test_it_is_small(dataset: str) -> None:
    assert sum(path.stat().st_size for path in sinsdata.load(dataset, "short").folder.iterdir()) < 800_000
