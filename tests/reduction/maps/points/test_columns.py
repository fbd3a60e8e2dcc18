import pytest

from labrun.reduction.maps.points.columns import read_columns
from labrun.reduction.spectrum.fault import Unreadable


def table(tmp_path, raw):
    path = tmp_path / "data.csv"
    path.write_bytes(raw)
    return path


@pytest.mark.parametrize(
    "raw",
    [b"x,Li\n1,2\n3,4\n", b"\xef\xbb\xbfx,Li\r\n1,2\r\n\r\n3,4\r\n", b"x;Li\n1;2\n3;4",
     b"x\tLi\n1\t2\n3\t4\n"],
)  # fmt: skip
def test_tables_of_several_makers_are_read_alike(tmp_path, raw):
    columns = read_columns(table(tmp_path, raw))

    assert columns.numbers("x").tolist() == [1, 3]
    assert columns.text("Li") == ["2", "4"]


def test_short_rows_and_columns_that_are_not_there_are_empty_cells(tmp_path):
    columns = read_columns(table(tmp_path, b"a,b\n1\n"))

    assert columns.text("b") == [""] and columns.text("c") == [""]


def test_text_among_numbers_is_none_and_can_be_named(tmp_path):
    columns = read_columns(table(tmp_path, b"Li\n1\nabc\n\nnan\ninf\n"))

    assert columns.odd("Li") == ["abc", "inf"]
    assert columns.numbers("Li")[0] == 1


@pytest.mark.parametrize(
    ("raw", "said"),
    [
        (b"", "is empty"),
        (b"\xff\xfe\x00", "not UTF-8 text"),
        (b"Li,Li\n1,2\n", "two columns of the name 'Li'"),
        (b'x,y\n"' + b"a" * 200_000 + b'",1\n', "is no table"),
    ],
)
def test_what_is_no_table_is_refused_with_its_name(tmp_path, raw, said):
    with pytest.raises(Unreadable, match=rf"data\.csv.*{said}"):
        read_columns(table(tmp_path, raw))


def test_a_file_that_cannot_be_opened_is_told_in_the_same_way(tmp_path):
    with pytest.raises(Unreadable, match="cannot be read"):
        read_columns(tmp_path / "nothing.csv")
