"""A run's map as a TIFF stack, read back by tifffile: pages, names, scale, and what is missing."""

import numpy as np
import pytest
import tifffile

from labrun.engine.export.formats import ExportFault
from labrun.engine.export.tiff import write
from labrun.engine.journal.journal import Journal
from labrun.schemas import journal as j


def point(x, y, li, unit="mm"):
    row = {"x": {"$quantity": [x, unit]}, "y": {"$quantity": [y, unit]}, "shot": "s", "Li": li,
           "mass": {"$quantity": [2 * li, "mg"]}}  # fmt: skip
    key = f"{x},{y}"
    return j.IterationEnded(
        loop="main/scan", index=0, key=key, fate="succeeded", row=row, file="data.csv"
    )


@pytest.fixture
def exported(tmp_path):
    """Writes the journal of a run with these points, and exports it."""
    folder = tmp_path / "2026-01-01_map_12345678"
    folder.mkdir()

    def make(*records):
        journal = Journal(folder / "journal.jsonl", sync=False)
        began = j.Started(run=folder.name, protocol="map", labrun="0", python="3")
        for record in (began, *records, j.Finished(fate="succeeded")):
            journal.append(record)
        journal.close()
        write(folder, tmp_path / "map.tif")
        return tifffile.TiffFile(tmp_path / "map.tif")

    return make


def test_each_column_of_a_grid_is_a_page_with_its_name_scale_and_origin(exported):
    with exported(
        point(1, 4, 1.5), point(1.5, 4, 2.5), point(2, 4, 3.5), point(1, 6, 4.5), point(2, 6, 6.5)
    ) as file:
        pages, told = file.asarray(), file.imagej_metadata
        per_mm = [np.divide(*file.pages[0].tags[f"{axis}Resolution"].value) for axis in ("X", "Y")]

    assert pages.dtype == np.float32
    np.testing.assert_array_equal(pages[0], [[4.5, np.nan, 6.5], [1.5, 2.5, 3.5]])
    assert told["Labels"] == ["Li", "mass (mg)"]
    assert told["unit"] == "mm"
    np.testing.assert_allclose(per_mm, [2.0, 0.5])
    # ImageJ: x = (pixel - origin) * its size, and y = (origin - pixel) * its size where it is inverted
    np.testing.assert_allclose([told["xorigin"], told["yorigin"]], [-2, 3])
    assert told["inverty"]


def test_a_grid_that_ends_at_0_has_an_origin_all_the_same(exported):
    with exported(*(point(x, y, x) for x in (0, 1) for y in (-2, 0))) as file:
        assert 0 < file.imagej_metadata["yorigin"] < 1e-6


def test_an_uneven_grid_has_pages_but_no_scale(exported):
    with exported(*(point(x, y, x) for x in (0, 1, 5) for y in (0, 1))) as file:
        assert file.asarray().shape == (2, 2, 3)
        assert not {"unit", "xorigin", "yorigin"} & {
            k for k, v in file.imagej_metadata.items() if v
        }


def test_points_that_are_no_grid_are_refused_with_the_way_on(exported):
    with pytest.raises(ExportFault, match="--to nexus takes points as they are"):
        exported(point(0, 0, 1.0), point(1, 3, 2.0), point(7, 2, 3.0))
