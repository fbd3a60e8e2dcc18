"""The page on the tables names every column with its unit, and no other."""

import re
from pathlib import Path

import pytest

from labrun.reduction.batch.looks import SUFFIXES
from labrun.reduction.lines.usual import USUAL_LINES
from labrun.reduction.tables.columns import TABLES

PAGE = (Path(__file__).parents[2] / "docs/reference/reduction-tables.md").read_text("utf-8")


@pytest.mark.parametrize("table", TABLES)
def test_the_page_has_the_columns_of_each_table_in_their_order(table):
    section = re.search(rf"^## {table}:.*?(?=^## )", PAGE, re.M | re.S)[0]
    cells = [line.split("|")[1] for line in section.splitlines() if line.startswith("| `")]

    assert re.findall(r"`(\w+)`", "".join(cells)) == [column.name for column in TABLES[table]]


@pytest.mark.parametrize("table", TABLES)
def test_the_page_has_the_unit_of_each_column_that_has_one(table):
    section = re.search(rf"^## {table}:.*?(?=^## )", PAGE, re.M | re.S)[0]
    for column in TABLES[table]:
        (row,) = [
            line for line in section.splitlines() if re.match(rf"\|[^|]*`{column.name}`", line)
        ]
        unit = row.split("|")[2].strip().replace("cm³", "cm3").removeprefix("electrons ")

        assert column.unit in ("", unit)


def test_the_page_names_the_usual_elements_and_the_files_that_are_taken():
    assert f"for {' '.join(USUAL_LINES)}," in PAGE
    assert set(re.search(r"below it: `([^`]+)`", PAGE)[1].split()) == SUFFIXES
