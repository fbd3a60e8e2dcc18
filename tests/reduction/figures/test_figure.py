import numpy as np
import pytest

from labrun.reduction import draw_element_maps, element_map
from labrun.reduction.figures.figure import element_maps_figure, round_length

PNG = b"\x89PNG"


def core(nx=5, ny=11, hole=True):
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(nx) * 0.2, np.arange(ny) * 0.2))
    values = x + y
    values[0] = np.nan if hole else 0
    return element_map(x, y, values)


def test_a_picture_is_written_at_printing_resolution(tmp_path):
    path = draw_element_maps({"Li": core(), "K": core()}, tmp_path / "maps.png", title="Core 7")
    picture = path.read_bytes()
    width = int.from_bytes(picture[16:20], "big")

    assert picture.startswith(PNG)
    assert width > 600


def test_each_element_has_a_panel_with_its_name_and_there_is_one_colour_bar():
    figure = element_maps_figure({"Li": core(), "K": core(), "Si": core()})
    titles = [axes.get_title() for axes in figure.axes]

    assert titles == ["Li", "K", "Si", ""]


def test_many_wide_maps_are_laid_out_in_rows():
    figure = element_maps_figure({str(n): core(nx=30, ny=10) for n in range(8)})
    width, height = figure.get_size_inches()

    assert width < 15 and height < 15


@pytest.mark.parametrize("suffix", ["svg", "pdf"])
def test_the_suffix_decides_the_format(tmp_path, suffix):
    path = draw_element_maps({"Li": core()}, tmp_path / f"maps.{suffix}")

    assert path.stat().st_size > 1_000


def test_no_map_is_no_figure(tmp_path):
    with pytest.raises(ValueError, match="no map"):
        draw_element_maps({}, tmp_path / "maps.png")


@pytest.mark.parametrize(("most", "length"), [(1.6, 1), (2, 2), (0.07, 0.05), (430, 200), (9.9, 5)])
def test_the_scale_bar_is_of_a_round_length(most, length):
    assert round_length(most) == pytest.approx(length)
