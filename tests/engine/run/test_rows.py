"""Rows as CSV: units in the header, nulls as empty cells, whole again after a crash."""

from pathlib import Path

import pytest

from labrun.engine.journal.encode import encode
from labrun.engine.language.table import Tables
from labrun.engine.run.files import NoRoom
from labrun.engine.run.rows import Rows, restore_rows
from labrun.schemas.journal import IterationEnded
from labrun.schemas.quantity import quantity
from labrun.web.results.tables import read_table


def test_the_header_bears_the_units_and_cells_are_bare_numbers(tmp_path):
    rows = Rows(tmp_path / "data.csv", {"x": None, "n": None})
    rows.write("0", {"x": quantity(0.2, "mm"), "n": 3}, "succeeded")
    rows.write("1", {"x": quantity(400, "um"), "n": None}, "failed")

    lines = (tmp_path / "data.csv").read_text().splitlines()

    assert lines == ["key,x_mm,n,fate", "0,0.2,3,succeeded", "1,0.4,,failed"]


def test_a_unit_that_shows_late_still_comes_into_the_header(tmp_path):
    rows = Rows(tmp_path / "data.csv", {"t": None})
    rows.write("0", {"t": None}, "failed")
    rows.write("1", {"t": quantity(5, "K")}, "succeeded")

    assert (tmp_path / "data.csv").read_text() == "key,t_K,fate\n0,,failed\n1,5,succeeded\n"


def test_text_with_commas_and_quotes_is_one_cell(tmp_path):
    rows = Rows(tmp_path / "data.csv", {"a": None})
    rows.write("0,1", {"a": 'he said "no"'}, "succeeded")

    assert (tmp_path / "data.csv").read_text().splitlines()[1] == '"0,1","he said ""no""",succeeded'


def test_text_that_a_spreadsheet_would_compute_is_written_as_text_and_read_as_it_was(tmp_path):
    rows = Rows(tmp_path / "data.csv", {"note": None, "x": None})
    rows.write("-4,1", {"note": "=cmd|' /C calc'!A0", "x": -4}, "succeeded")

    assert (tmp_path / "data.csv").read_text().splitlines()[
        1
    ] == "\"-4,1\",'=cmd|' /C calc'!A0,-4,succeeded"
    row = Tables(tmp_path / "p.yaml", [tmp_path])("data.csv").item(0)
    assert (
        row["note"] == "=cmd|' /C calc'!A0" == read_table(tmp_path, "data.csv").columns["note"][0]
    )


@pytest.fixture
def shown(monkeypatch):
    """On Windows: the tables that a spreadsheet program shows, which nobody may write then."""
    names = set()

    def refusing(act):
        def refuses(path, *more, **named):
            writes = act is Path.write_text or more[:1] not in ((), ("r",))
            if path.name in names and writes:
                raise PermissionError(13, "Permission denied", str(path))
            return act(path, *more, **named)

        return refuses

    for act in (Path.write_text, Path.open, Path.unlink):
        monkeypatch.setattr(Path, act.__name__, refusing(act))
    monkeypatch.setattr("labrun.engine.run.rows.WINDOWS", True)
    monkeypatch.setattr("labrun.system.files.WINDOWS", True)
    return names


def test_rows_wait_while_a_spreadsheet_program_shows_their_table(tmp_path, shown):
    rows = Rows(tmp_path / "data.csv", {"x": None})
    said = [rows.write("0", {"x": None}, "failed")]
    shown.add("data.csv")
    said += [rows.write(key, {"x": quantity(5, "K")}, "succeeded") for key in ("1", "2")]
    meanwhile = (tmp_path / "data.csv").read_text()
    shown.clear()
    said.append(rows.write("3", {"x": quantity(6, "K")}, "succeeded"))

    assert [bool(text) for text in said] == [False, True, False, False]
    assert "data.csv is open in another program" in said[1]
    assert meanwhile == "key,x,fate\n0,,failed\n"
    assert (tmp_path / "data.csv").read_text() == (
        "key,x_K,fate\n0,,failed\n1,5,succeeded\n2,5,succeeded\n3,6,succeeded\n"
    )
    assert rows.finish() == ""


def test_rows_that_waited_to_the_end_are_beside_their_table(tmp_path, shown):
    rows = Rows(tmp_path / "data.csv", {"x": None})
    rows.write("0", {"x": 1}, "succeeded")
    shown.add("data.csv")
    rows.write("1", {"x": 2}, "succeeded")

    assert "its last 1 rows are in data-rest.csv" in rows.finish()
    assert (tmp_path / "data-rest.csv").read_text() == "key,x,fate\n1,2,succeeded\n"


def test_elsewhere_a_table_that_may_not_be_written_ends_the_run(tmp_path, shown, monkeypatch):
    monkeypatch.setattr("labrun.engine.run.rows.WINDOWS", False)
    shown.add("data.csv")

    with pytest.raises(NoRoom, match="Permission denied"):
        Rows(tmp_path / "data.csv", {"x": None}).write("0", {"x": 1}, "succeeded")


def test_a_torn_table_is_whole_after_it_was_made_again_from_the_journal(tmp_path):
    rows = Rows(tmp_path / "data.csv", {"x": None})
    records = []
    for index in range(3):
        row = {"x": quantity(index / 10, "mm")}
        rows.write(str(index), row, "succeeded")
        records.append(
            IterationEnded(
                loop="main/l", index=index, key=str(index), fate="succeeded", row=encode(row),
                file="data.csv",
            )
        )  # fmt: skip
    whole = (tmp_path / "data.csv").read_text()
    (tmp_path / "data.csv").write_text(whole[:-4])

    again = Rows(tmp_path / "data.csv", {"x": None})
    restore_rows(tmp_path, records, {"data.csv": again})

    assert (tmp_path / "data.csv").read_text() == whole
