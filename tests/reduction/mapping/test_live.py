"""Maps of a run that goes on are those that its report would draw from the rows so far."""

from labrun.reduction.mapping.live import draw
from labrun.reduction.mapping.report import make

HEADER = "key,x_mm,y_mm,shot,Li,fate\n"
ROWS = (
    "a,0,0,1,5,succeeded\nb,0.2,0,2,6,succeeded\nc,0,0.2,3,7,succeeded\nd,0.2,0.2,4,8,succeeded\n"
)


def test_the_figure_is_that_of_a_report_and_nothing_is_written_into_the_run(tmp_path):
    run = tmp_path / "2026-11-21_map_7f3a"
    run.mkdir()
    (run / "data.csv").write_text(HEADER + ROWS)
    drawn = draw(run)
    before = [path.name for path in run.iterdir()]
    make(run)

    assert before == ["data.csv"]
    assert drawn == {"element_maps.png": (run / "element_maps.png").read_bytes()}


def test_a_row_that_is_being_written_does_not_count(tmp_path):
    (tmp_path / "data.csv").write_text(HEADER + ROWS)
    whole = draw(tmp_path)
    with (tmp_path / "data.csv").open("a") as file:
        file.write("e,0.4,0,5,99999")

    assert draw(tmp_path) == whole


def test_of_rows_without_a_map_there_is_nothing(tmp_path):
    (tmp_path / "data.csv").write_text(HEADER)

    assert draw(tmp_path) == {}
