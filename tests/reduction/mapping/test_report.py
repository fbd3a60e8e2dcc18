import pytest

from labrun.reduction.mapping.report import make

HEADER = "key,x_mm,y_mm,shot,Li,K,fate\n"
ROWS = """\
a,0,0,1,5,2,succeeded
b,0.2,0,2,6,3,succeeded
c,0,0.2,3,,,failed
d,0.2,0.2,4,7,1,succeeded
"""


def test_a_run_gets_its_element_maps(tmp_path):
    (tmp_path / "data.csv").write_text(HEADER + ROWS)
    written = make(tmp_path)

    assert written == [tmp_path / "element_maps.png"]
    assert written[0].stat().st_size > 10_000


def test_points_are_taken_from_whichever_table_has_them(tmp_path):
    (tmp_path / "data.csv").write_text("key,sample,fate\nA,A,succeeded\n")
    (tmp_path / "data-scan.csv").write_text(HEADER + ROWS)

    assert [path.name for path in make(tmp_path)] == ["element_maps.png"]


@pytest.mark.parametrize(
    "rows",
    [
        "",
        HEADER,
        HEADER + "a,0,0,1,5,2,succeeded\nb,0.2,0,2,6,3,succeeded\n",
        HEADER + "a,0,0,1,,,failed\nb,1,1,2,,,failed\n",
        "key,x_mm,y_mm,mass\na,0,0,1\nb,1,1,2\n",
        "key,Li\na,5\nb,6\n",
        "key,x,y,Li\na,one,two,5\n",
    ],
)
def test_a_run_with_nothing_to_map_gets_no_file(tmp_path, rows):
    (tmp_path / "data.csv").write_text(rows)

    assert make(tmp_path) == []
    assert [path.name for path in tmp_path.iterdir()] == ["data.csv"]


def test_a_run_without_rows_gets_no_file(tmp_path):
    assert make(tmp_path) == []


def test_a_row_that_is_cut_short_is_a_hole(tmp_path):
    (tmp_path / "data.csv").write_text("x,y,Li\n0,0,1\n1,0,2\n0,1,3\n1,1")

    assert make(tmp_path) == [tmp_path / "element_maps.png"]


def test_a_line_of_points_gets_its_profile(tmp_path):
    (tmp_path / "data.csv").write_text("x_mm,Li,K\n0,5,1\n1,6,2\n2,7,1\n")

    assert make(tmp_path) == [tmp_path / "line_scan.png"]


def test_each_sample_gets_a_figure_of_its_own(tmp_path):
    rows = "".join(f"{s},{x},{y},{x + y}\n" for s in "AB" for x in (0, 1) for y in (0, 1))
    (tmp_path / "data-scan.csv").write_text("sample,x,y,Li\n" + rows)

    assert [path.name for path in make(tmp_path)] == ["element_maps_A.png", "element_maps_B.png"]
