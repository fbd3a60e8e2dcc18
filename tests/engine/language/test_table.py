"""`csv(...)`: rows with typed columns, units from header or call, every cell checked before the run."""

import pytest

from labrun.engine.check import check_file
from labrun.engine.language.column import TableFault
from labrun.engine.language.table import Tables
from labrun.schemas.quantity import quantity

SAMPLES = "sample,x (mm),y_mm,depth [um],n,ok\nA,1,2.5,10,3,true\nB,11,2.5,,4,false\n"


def table(tmp_path, text, **kinds):
    (tmp_path / "t.csv").write_text(text, encoding="utf-8", newline="")
    return Tables(tmp_path / "protocol.yaml", [tmp_path])("t.csv", **kinds)


def test_header_units_and_inferred_kinds_make_the_fields_of_a_row(tmp_path):
    rows = table(tmp_path, SAMPLES, y="mm")

    assert rows[0] == {
        "sample": "A", "x": quantity(1, "mm"), "y": quantity(2.5, "mm"),
        "depth": quantity(10, "um"), "n": 3, "ok": True,
    }  # fmt: skip
    assert rows[1]["depth"] is None
    assert len(rows) == 2


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("\ufeffa,b\n1,2\n", {"a": 1, "b": 2}),
        ("a;b\r\n1;2\r\n", {"a": 1, "b": 2}),
        ("a\tb\n1\tx\n", {"a": 1, "b": "x"}),
        ("# made by hand\na,b\n1,2\n\n", {"a": 1, "b": 2}),
        ('a,b\n"one, two",2\n', {"a": "one, two", "b": 2}),
        ("Sample no.,b\n7,2\n", {"Sample_no": 7, "b": 2}),
        ("a,b\n1\n", {"a": 1, "b": ""}),
        ("a,b\n1,2,,\n", {"a": 1, "b": 2}),
        ("a;b\n1,5;x\none;y\n", {"a": "1,5", "b": "x"}),
        ("a;b\n1,5;x\n2;y\n", {"a": 1.5, "b": "x"}),
        ("a (mm);b\n1,5E+01;1.5\n", {"a": quantity(15, "mm"), "b": 1.5}),
        ("sep=;\r\na;b\r\n1,500;x\r\n", {"a": 1.5, "b": "x"}),
        ("a;key\n1,5;3,1\n", {"a": 1.5, "key": "3,1"}),
        (",a\n0,1\n", {"a": 1}),
        ("a\n1e3\n", {"a": 1000.0}),
        ("a\n007\n", {"a": 7}),
    ],
)
def test_tables_of_other_programs_are_read(tmp_path, text, first):
    assert table(tmp_path, text)[0] == first


@pytest.mark.parametrize(
    ("text", "kinds", "says"),
    [
        ("a,b\n1,x\n", {"b": "mm"}, "row 1: b is 'x', which is not a number (mm)"),
        ("a\n1\n2.5\n", {"a": "integer"}, "row 2: a is '2.5', which is not a whole number"),
        ("a\n1\n", {"c": "mm"}, "has no column c; it has a"),
        ("a\n1\n", {"a": "parsec7"}, "neither a unit nor text, number"),
        ("a (mm)\n1\n", {"a": "s"}, "is in mm, not in s"),
        ("a (wug)\n1\n", {}, "wug is not a unit"),
        ("a,a\n1,2\n", {}, "two columns 'a'"),
        ("", {}, "is empty"),
        ('a\n"never closed\n', {}, "is not a table"),
        ("a\nnan\n", {"a": "number"}, "which is not a number"),
        ("a,b\n1,2\n1,2,3\n", {}, "row 2 has 3 cells, and the first line names 2"),
        ("a\tb\n1,5\tx\n2\ty\n", {}, "a is '1,5' in a row; numbers have a decimal point"),
        ("a (mm)\tb\n1,5\tx\n", {}, "not a number (mm); numbers have a decimal point"),
        (
            "a (mm);b\n1,5;x\n1.000;x\n",
            {},
            "row 2: a is '1.000', which is not a number (mm); where",
        ),
        (
            "Plate 1;;\nsample;x (mm);y\nA;1;2\n",
            {},
            "names one column, 'Plate 1', and rows have more",
        ),
        (
            "PK\x03\x04\x00",
            {},
            "not text; a workbook has to be saved as a table (in Excel: CSV UTF-8)",
        ),
    ],
)
def test_a_table_that_does_not_fit_is_refused_with_its_row(tmp_path, text, kinds, says):
    with pytest.raises(TableFault) as fault:
        table(tmp_path, text, **kinds)

    assert says in str(fault.value)


@pytest.mark.posix("a backslash stands between folders there")
def test_a_path_as_windows_has_it_is_told_with_slashes(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "t.csv").write_text("a\n1\n")

    with pytest.raises(TableFault, match=r"there is no file data\\t.csv .*did you mean data/t.csv"):
        Tables(tmp_path / "p.yaml", [tmp_path])("data\\t.csv")


def test_a_file_that_is_not_there_suggests_the_one_that_is(tmp_path):
    (tmp_path / "samples.csv").write_text("a\n1\n")
    with pytest.raises(TableFault) as fault:
        Tables(tmp_path / "p.yaml", [tmp_path])("sampels.csv")

    assert "there is no file sampels.csv beside p.yaml; did you mean samples.csv?" in str(
        fault.value
    )


@pytest.mark.parametrize(
    ("expression", "code"),
    [
        ("csv('t.csv')", None),
        ("csv('t.csv', y='mm')", None),
        ("csv('nope.csv')", "E313"),
        ("csv(params.file)", "E307"),
        ("csv()", "E307"),
    ],
)
def test_the_checker_reads_the_table(tmp_path, expression, code):
    (tmp_path / "t.csv").write_text(SAMPLES)
    (tmp_path / "p.yaml").write_text(
        "labrun: 1\nname: t\nparams: {file: {type: string, default: t.csv}}\n"
        f'steps:\n  - foreach: {{s: "${{{{ {expression} }}}}"}}\n'
        '    steps: [{log: "${{ s.sample }} ${{ params.file }}"}]\n'
    )

    assert [p.code for p in check_file(tmp_path / "p.yaml").problems] == ([code] if code else [])


def test_a_field_of_a_row_has_its_unit_in_the_checks(tmp_path):
    (tmp_path / "t.csv").write_text("x (mm)\n1\n900\n")
    (tmp_path / "p.yaml").write_text(
        "labrun: 1\nname: t\ndevices: {gantry: gantry@1}\nsteps:\n"
        "  - foreach: {s: \"${{ csv('t.csv') }}\"}\n    steps:\n"
        '      - {do: gantry.move_to, with: {x: "${{ s.x }}"}}\n'
        '      - {do: gantry.move_to, with: {x: "${{ s.x + 1 s }}"}}\n'
        '      - {do: gantry.move_to, with: {x: "${{ s.z }}"}}\n'
    )
    problems = check_file(tmp_path / "p.yaml").problems

    assert [(p.line, p.code) for p in problems] == [(7, "E207"), (8, "E308"), (9, "E301")]
