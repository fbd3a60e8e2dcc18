"""A table on the disk is held against the rows of the journal as the engine writes them."""

import pytest

from labrun.engine.journal.encode import encode
from labrun.engine.run.rows import Rows
from labrun.schemas.journal import IterationEnded
from labrun.schemas.quantity import quantity
from labrun.web.report.rows_hash import RowsHash

ROWS = [
    {"x": quantity(1, "mm"), "shot": "s, 1", "Li": 0.1 + 0.2, "ok": True, "n": 3, "many": [1, 2]},
    {"x": quantity(0.2, "cm"), "shot": None, "Li": 1e-17, "ok": False, "n": None, "many": None},
    {"x": None, "shot": 'a "quoted" one', "Li": None, "ok": None, "n": 12345678, "many": {"a": 1}},
]


@pytest.fixture
def written(tmp_path):
    """A table as the engine writes it, and what the journal has of it."""
    table, told = Rows(tmp_path / "data.csv", dict.fromkeys(ROWS[0])), RowsHash()
    for index, row in enumerate(ROWS):
        table.write(f"{index},0", row, "succeeded")
        told.add(
            IterationEnded(
                loop="main/scan", index=index, key=f"{index},0", fate="succeeded", row=encode(row)
            )
        )
    return table.path, told


def test_a_table_as_the_engine_wrote_it_fits(written):
    path, told = written

    assert told.count == 3
    assert told.fits(path)


@pytest.mark.parametrize(
    ("old", "new"),
    [("0.3", "0.4"), ("s, 1", "s, 2"), ("succeeded\n", "failed\n"), ("12345678", "")],
)
def test_a_cell_that_was_changed_does_not_fit(written, old, new):
    path, told = written
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))

    assert not told.fits(path)


def test_a_row_too_many_a_row_too_few_and_no_table_do_not_fit(written):
    path, told = written
    text = path.read_text()

    path.write_text(text + text.splitlines(keepends=True)[-1])
    assert not told.fits(path)
    path.write_text("".join(text.splitlines(keepends=True)[:-1]))
    assert not told.fits(path)
    path.unlink()
    assert not told.fits(path)
