import numpy as np
import pytest

from labrun.reduction.maps.points.rows import read_rows
from labrun.reduction.spectrum.fault import Unreadable


def rows(tmp_path, text):
    path = tmp_path / "data.csv"
    path.write_text(text)
    return read_rows(path)


def test_coordinates_may_bear_their_unit(tmp_path):
    found = rows(tmp_path, "x_um,y_um,Li,shot\n1,2,5,a\n")

    assert (found.unit, found.x[0], found.y[0]) == ("um", 1, 2)
    assert list(found.area) == ["Li"]


def test_one_coordinate_is_a_line(tmp_path):
    assert rows(tmp_path, "x,Li\n1,5\n2,6\n").y.tolist() == [0, 0]


def test_samples_are_a_column_or_what_stands_before_the_slash_of_a_key(tmp_path):
    assert rows(tmp_path, "sample,x,y\nA,1,1\n").sample == ["A"]
    assert rows(tmp_path, 'key,x,y\n"SPD-01/0,0",1,1\n').sample == ["SPD-01"]
    assert rows(tmp_path, 'key,x,y\n"0,0",1,1\n').sample == [""]


def test_text_in_numbers_is_said_and_the_row_has_no_place(tmp_path):
    found = rows(tmp_path, "x,y,Li\none,1,5\n2,2,6\n")

    assert found.placed.tolist() == [False, True]
    assert found.notes == ["data.csv: column x has a cell that is not a number, such as 'one'"]


def test_an_empty_cell_of_an_element_is_a_hole(tmp_path):
    assert np.isnan(rows(tmp_path, "x,y,Li\n1,1,\n").area["Li"]).all()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("key,Li\na,1\n", "no coordinates.*x_mm and y_mm.*columns are key, Li"),
        ("x,y,Li\n", "no row"),
        ("x_mm,y_um\n1,2\n", "different units"),
    ],
)
def test_rows_without_places_are_refused_with_a_sentence(tmp_path, text, said):
    with pytest.raises(Unreadable, match=said):
        rows(tmp_path, text)


def test_turns_of_a_loop_are_one_sample(tmp_path):
    found = rows(tmp_path, "key,x,y,Li\n0/a,0,0,1\n1/b,1,0,2\n1/2/c,1,1,2\n")

    assert found.sample == ["", "", ""]
