import numpy as np
import pytest

from labrun.reduction.maps.scattered import along_line, map_of, nearest_map


def grid(nx=6, ny=5, pitch=0.2):
    return (axis.ravel() for axis in np.meshgrid(np.arange(nx) * pitch, np.arange(ny) * pitch))


def test_a_grid_with_holes_stays_a_grid():
    x, y = grid()
    kept = np.arange(30) % 4 > 0
    found = map_of(x[kept], y[kept], x[kept])

    assert found.values.shape == (5, 6)
    assert np.isnan(found.values).sum() == 30 - kept.sum()


def test_scattered_points_are_each_seen_around_their_place():
    random = np.random.default_rng(2)
    x, y = random.uniform(0, 5, 80), random.uniform(0, 3, 80)
    found = map_of(x, y, np.arange(80.0))
    row, column = np.searchsorted(found.y, y), np.searchsorted(found.x, x)
    inside = (row < len(found.y)) & (column < len(found.x))

    assert np.mean(found.values[row[inside], column[inside]] == np.arange(80)[inside]) > 0.9
    assert np.isnan(found.values).any()


def test_a_fine_patch_in_a_coarse_map_has_small_cells():
    x, y = grid(nx=8, ny=8, pitch=1.0)
    fine_x, fine_y = grid(nx=4, ny=4, pitch=0.25)
    every_x, every_y = np.append(x, fine_x + 3.1), np.append(y, fine_y + 3.1)
    found = nearest_map(every_x, every_y, np.append(np.zeros(64), np.ones(16)))
    part = np.nanmean(found.values == 1)

    assert 0.005 < part < 0.06


@pytest.mark.parametrize("degrees", [0, 30, 90, 135])
def test_points_on_a_line_know_how_far_along_it_they_are(degrees):
    way = np.array([0.0, 1.0, 2.5, 4.0])
    angle = np.radians(degrees)
    found = along_line(1 + way * np.cos(angle), 2 + way * np.sin(angle))

    assert sorted(found) == pytest.approx(way.tolist()) or sorted(found) == pytest.approx(
        sorted(4 - way)
    )


def test_an_area_or_a_single_point_is_no_line():
    x, y = grid()

    assert along_line(x, y) is None
    assert along_line(np.zeros(1), np.zeros(1)) is None
    assert along_line(np.zeros(3), np.zeros(3)) is None
