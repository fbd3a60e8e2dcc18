import csv
import io

import pyarrow as pa

from labrun.reduction.tables.csv_text import CsvFile, csv_lines

ODD = ["plain", "a,b", 'say "no"', "two\nlines", "", "ünï", " space ", None]


def test_quotes_stand_only_where_they_are_needed_and_python_reads_it_back():
    table = pa.table({"text": pa.array(ODD), "n": pa.array(range(len(ODD)))})
    text = csv_lines(table).decode()
    back = [row[0] for row in csv.reader(io.StringIO(text, newline=""))]

    assert back == ["" if cell is None else cell for cell in ODD]
    assert text.startswith('plain,0\n"a,b",1\n"say ""no""",2\n')


def test_numbers_are_as_short_as_they_are_exact_and_unknown_ones_empty():
    values = [1.0, 0.1, 1e-7, 123456.789, None, -2.5]
    text = csv_lines(pa.table({"x": pa.array(values), "y": pa.array([1, None, 3, 4, 5, 6])}))
    cells = [line.split(",") for line in text.decode().splitlines()]

    assert [float(x) if x else None for x, _ in cells] == values
    assert [y for _, y in cells] == ["1", "", "3", "4", "5", "6"]
    assert max(len(x) for x, _ in cells) <= 10


def test_tables_follow_each_other_under_one_header(tmp_path):
    one = pa.table({"a": ["x"], "b": [1]})
    with CsvFile(tmp_path / "t.csv", one.schema) as file:
        file.write_table(one)
        file.write_table(one.slice(0, 0))
        file.write_table(one)

    assert (tmp_path / "t.csv").read_bytes() == b"a,b\nx,1\nx,1\n"
