import numpy as np
import pytest

from labrun.reduction.maps.points.gather import gather
from labrun.reduction.spectrum.fault import Unreadable

PEAKS = """\
spectrum,center_nm,area,area_err,element,stage,line_nm
s/1.csv,670.79,100,2,Li,1,670.78
s/2.csv,670.79,50,2,Li,1,670.78
s/2.csv,766.5,7,1,K,1,766.49
"""


def folder(tmp_path, **texts):
    for name, text in texts.items():
        (tmp_path / f"{name}.csv").write_text(text)
    return tmp_path


def test_rows_alone_are_enough_for_maps(tmp_path):
    points = gather(folder(tmp_path, data="x,y,Li\n0,0,1\n1,0,2\n"))

    assert points.area["Li"].tolist() == [1, 2]
    assert "no tables of `labrun reduce`" in points.notes[-1]


def test_tables_go_before_what_the_run_collected(tmp_path):
    data = "x,y,spectrum,Li,Rb\n0,0,2.csv,1,8\n1,0,1.csv,2,9\n2,0,,3,7\n"
    points = gather(folder(tmp_path, data=data, peaks=PEAKS))

    assert points.area["Li"].tolist()[:2] == [50, 100] and np.isnan(points.area["Li"][2])
    assert points.area["Rb"].tolist() == [8, 9, 7]
    assert points.total.tolist()[:2] == [57, 100]
    assert any("Rb: not in the tables" in note for note in points.notes)


def test_where_nothing_joins_it_says_what_was_compared(tmp_path):
    points = gather(folder(tmp_path, data="x,y,Li\n0,0,1\n1,0,2\n", peaks=PEAKS))

    assert "such as s/1.csv" in points.notes[0] and "all columns" in points.notes[0]
    assert points.area["Li"].tolist() == [1, 2]


def test_tables_without_rows_are_points_without_places(tmp_path):
    points = gather(folder(tmp_path, peaks=PEAKS))

    assert not points.placed.any()
    assert points.name == ["s/1.csv", "s/2.csv"]


def test_a_place_measured_twice_is_the_mean_and_that_is_said(tmp_path):
    points = gather(folder(tmp_path, data="x,y,Li\n0,0,1\n0,0,3\n0,0,\n1,0,5\n"))

    assert points.area["Li"].tolist() == [2, 5]
    assert points.notes[-1] == "a place was measured more than once; the mean is shown"


def test_several_tables_and_samples_keep_their_points_apart(tmp_path):
    data = "sample,x,y,Li\nA,0,0,1\nB,0,0,2\n"
    points = gather(folder(tmp_path, data=data, **{"data-fine": "x,y,Li\n0,0,3\n"}))

    assert sorted(zip(points.sample, points.area["Li"].tolist(), strict=True)) == [
        ("A", 1), ("B", 2), ("fine", 3)
    ]  # fmt: skip


def test_spectra_that_are_not_reduced_come_with_the_command_that_does_it(tmp_path):
    (tmp_path / "spectra").mkdir()
    (tmp_path / "spectra" / "1.csv").write_text("")

    with pytest.raises(Unreadable, match=r"1 files .* `labrun reduce .*` makes their tables"):
        gather(folder(tmp_path, data="x,y,shot\n0,0,1\n"))


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (None, "neither data.csv nor the tables"),
        ("", "is empty"),
        ("key,Li\na,1\n", "no coordinates"),
        ("x,y,mass\n0,0,1\n", "no column of an element"),
        ("x,y,Li\none,two,1\n", "1 of 1 rows have no place"),
    ],
)
def test_what_cannot_be_mapped_is_said_in_a_sentence(tmp_path, data, said):
    if data is not None:
        (tmp_path / "data.csv").write_text(data)

    with pytest.raises(Unreadable, match=said):
        gather(tmp_path)


def test_no_folder_is_no_folder(tmp_path):
    with pytest.raises(Unreadable, match="is not a folder"):
        gather(tmp_path / "nothing")
