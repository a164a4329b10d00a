"""The dataset cards say what the schema says: every table, every column, every unit."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sinsdata.format.schema import DATASETS

CARDS = Path(__file__).resolve().parents[2] / "datasets" / "cards"


def _rows(dataset: str, table: str) -> list[tuple[str, str, str]]:
    """Return column, unit and description of a table of a card, one row a column."""
    text = (CARDS / f"{dataset}.md").read_text(encoding="utf-8")
    (section,) = re.findall(rf"^### {table}\n(.*?)(?=^##)", text, re.DOTALL | re.MULTILINE)
    lines = [line.strip("|").split("|") for line in section.splitlines() if line.startswith("|")]
    assert [cell.strip() for cell in lines[0]] == ["column", "unit", "what"]
    return [(name, unit.strip(), what.strip()) for names, unit, what in lines[2:] for name in names.strip().split(", ")]


def test_every_dataset_has_a_card_and_every_card_a_dataset() -> None:
    assert sorted(path.stem for path in CARDS.glob("*.md")) == sorted(DATASETS)


@pytest.mark.parametrize("dataset", DATASETS)
def test_a_card_has_the_tables_of_the_schema(dataset: str) -> None:
    text = (CARDS / f"{dataset}.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^### (\w+)$", text, re.MULTILINE)) == sorted(DATASETS[dataset].tables)
    assert DATASETS[dataset].doi in text


@pytest.mark.parametrize(("dataset", "table"), [(name, table) for name in DATASETS for table in DATASETS[name].tables])
def test_a_table_of_a_card_has_the_columns_and_units_of_the_schema(dataset: str, table: str) -> None:
    rows = _rows(dataset, table)
    assert [(name, unit) for name, unit, _ in rows] == [
        (column.name, column.unit) for column in DATASETS[dataset].tables[table]
    ]
    assert all(what for _, _, what in rows)
