from pathlib import Path

from labrun.reduction.maps.points.columns import Columns
from labrun.reduction.maps.points.join import join


def columns(**cells):
    return Columns(Path("data.csv"), cells, len(next(iter(cells.values()))))


def test_rows_name_their_spectra_by_path_file_name_or_stem():
    found, how = join(columns(spectrum=["spectra/b.csv", "a.csv", "c", ""]),
                      ["a.csv", "b.csv", "sub/c.csv"])  # fmt: skip

    assert found == [1, 0, 2, -1]
    assert how == "column spectrum"


def test_where_names_repeat_the_end_of_the_path_decides():
    spectra = ["A/spectra/1.csv", "B/spectra/1.csv"]

    assert join(columns(file=["B/spectra/1.csv", "A\\spectra\\1.csv"]), spectra)[0] == [1, 0]
    assert join(columns(file=["1.csv"]), spectra)[0] == [-1]


def test_the_column_that_names_most_counts():
    found, how = join(columns(shot=["1", "x"], file=["2.csv", "1.csv"]), ["1.csv", "2.csv"])

    assert (found, how) == ([1, 0], "column file")


def test_a_key_is_the_end_of_a_file_name():
    spectra = ["spectra/core_3_7.csv", "spectra/core_13_7.csv", "spectra/SPD-01_0_0.csv"]
    found, how = join(columns(key=["3,7", "13,7", "SPD-01/0,0", "9,9"]), spectra)

    assert found == [0, 1, 2, -1]
    assert how == "key at the end of the file name"


def test_a_key_that_ends_two_names_joins_neither():
    assert join(columns(key=["1,1"]), ["a_1_1.csv", "b_1_1.csv"]) == ([-1], "")


def test_nothing_in_common_joins_nothing():
    assert join(columns(shot=["a", "b"]), ["1.csv"]) == ([-1, -1], "")


def test_a_number_is_a_file_name_in_the_usual_column_only():
    assert join(columns(Li=["1", "2"]), ["1.csv", "2.csv"])[1] == ""
    assert join(columns(spectrum=["2", "1"]), ["1.csv", "2.csv"])[0] == [1, 0]
