"""Rows as CSV: units in the header, nulls as empty cells, whole again after a crash."""

from labrun.engine.journal.encode import encode
from labrun.engine.language.table import Tables
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
