"""A run as NeXus, read back by h5py: axes, units, the default plot, and what is missing."""

import h5py
import numpy as np
import pytest

from labrun.engine.export.nexus import _evened, write
from labrun.engine.journal.journal import Journal
from labrun.schemas import journal as j

HASH = "0" * 64


def quantity(value, unit="mm"):
    return {"$quantity": [value, unit]}


def point(key, x, y, li, **more):
    row = {"x": quantity(x), "y": quantity(y), "shot": f"shot-{key}", "Li": li, **more}
    return j.IterationEnded(
        loop="main/scan", index=0, key=key, fate="succeeded", row=row, file="data.csv"
    )


def export(key, name, again=1):
    id = f"2026-01-01_map_12345678/main/scan/{key}/export/{again}"
    return j.GoalEnded(id=id, state="SUCCEEDED", result={}, files={name: HASH})


@pytest.fixture
def exported(tmp_path):
    """Writes the journal of a run, exports it, and opens what was made."""
    folder = tmp_path / "runs" / "2026-01-01_map_12345678"
    (folder / "spectra").mkdir(parents=True)
    (folder / "protocol.yaml").write_text("labrun: 1\nname: map\n")
    files = []

    def make(*records):
        journal = Journal(folder / "journal.jsonl", sync=False)
        began = j.Started(run=folder.name, protocol="map", labrun="0", python="3")
        for record in (began, *records, j.Finished(fate="succeeded")):
            journal.append(record)
        journal.close()
        write(folder, tmp_path / "map.nxs")
        files.append(h5py.File(tmp_path / "map.nxs"))
        return files[0]["entry"]

    make.folder = folder
    yield make
    for file in files:
        file.close()


def test_a_grid_is_an_image_over_its_axes_with_a_hole(exported):
    entry = exported(
        point("0", 0, 0, 1.5), point("1", 0.5, 0, 2.5), point("2", 0.5, 2, None),
        point("1", 0.5, 0, 3.5),
    )  # fmt: skip
    data = entry["data"]

    assert entry.file.attrs["default"] == "entry" and entry.attrs["default"] == "data"
    assert data.attrs["signal"] == "Li" and list(data.attrs["axes"]) == ["y", "x"]
    assert (list(data["x"]), list(data["y"])) == ([0, 0.5], [0, 2])
    assert data["x"].attrs["units"] == data["y"].attrs["units"] == "mm"
    np.testing.assert_array_equal(
        data["Li"], [[1.5, 3.5], [np.nan, np.nan]]
    )  # the newest of its key
    assert data["shot"].asstr()[0].tolist() == ["shot-0", "shot-1"]
    assert data["fate"].asstr()[1].tolist() == ["", "succeeded"]
    assert [one.keys() for one in data["Li"].dims] == [["y"], ["x"]]
    assert entry["protocol/data"].asstr()[()].startswith("labrun: 1")
    assert entry["entry_identifier"].asstr()[()] == "2026-01-01_map_12345678"


def test_a_line_lies_along_its_axis_and_anything_else_along_its_rows(exported):
    line = [
        point(str(n), 1.5 * n, 4, n, speed=quantity(n, "mm/s"), Li_wt_percent_err=0.1)
        for n in range(4)
    ]
    apart = [
        j.IterationEnded(
            loop="main/other", index=n, key=str(n), fate="succeeded", file="other.csv",
            row={"x": quantity(x), "y": quantity(y), "row": n},
        )
        for n, (x, y) in enumerate([(0, 0), (1, 5), (2, 7), (4, 9)])
    ]  # fmt: skip
    entry = exported(*line, *apart)

    assert list(entry["data"].attrs["axes"]) == ["x"]
    assert list(entry["data/speed"]) == [0, 1, 2, 3]
    assert entry["data/speed"].attrs["units"] == "mm / s"
    assert entry["data/Li_wt_percent_err"].attrs["units"] == "wt %"
    assert list(entry["data/y"]) == [4, 4, 4, 4] and entry["data/y"].attrs["units"] == "mm"
    assert list(entry["other"].attrs["axes"]) == ["row_"]
    assert list(entry["other/row"]) == [0, 1, 2, 3] and list(entry["other/y"]) == [0, 5, 7, 9]


def test_what_a_reducer_told_as_areas_has_their_unit_whatever_its_column_is_called(exported):
    def reduced(key, li):
        id = f"2026-01-01_map_12345678/main/scan/{key}/analyse/1"
        return j.GoalEnded(id=id, state="SUCCEEDED", result={"areas": {"Li": li, "K": 0}})

    entry = exported(
        reduced("0", 7.25), point("0", 0, 0, 1, lithium=7.25, shots=7.25),
        reduced("1", 0), point("1", 1, 0, 2, lithium=0, shots=3),
    )  # fmt: skip

    assert entry["data/lithium"].attrs["units"] == "counts nm"
    assert "units" not in entry["data/shots"].attrs and "units" not in entry["data/Li"].attrs


def test_spectra_are_a_cube_and_those_that_cannot_be_read_are_named(exported):
    lines = {
        "a": "200,1\n201,2\n202,3\n",
        "b": "200,4\n201,5\n202,6\n",
        "c": "300,1\n301,1\n302,1\n",
    }
    for name, text in lines.items():
        (exported.folder / "spectra" / f"{name}.csv").write_text(f"nm,counts\n{text}")
    entry = exported(
        export("0", "spectra/c.csv"), export("0", "spectra/a.csv", 2), point("0", 0, 0, 1),
        export("1", "spectra/lost.csv"), point("1", 0.5, 0, 2),
        export("2", "spectra/c.csv"), point("2", 0, 2, 3),
        export("3", "spectra/b.csv"), point("3", 0.5, 2, 4),
    )  # fmt: skip
    data = entry["data_spectra"]

    assert data.attrs["signal"] == "intensity" and data.attrs["interpretation"] == "spectrum"
    assert list(data.attrs["axes"]) == ["y", "x", "wavelength"]
    assert list(data["wavelength"]) == [200, 201, 202] and data["wavelength"].attrs["units"] == "nm"
    assert data["x"].attrs["units"] == "mm"
    assert data["intensity"][0, 0].tolist() == [1, 2, 3] and data["intensity"][1, 1].tolist() == [
        4,
        5,
        6,
    ]
    assert np.isnan(data["intensity"][0, 1]).all() and np.isnan(data["intensity"][1, 0]).all()
    assert [text.partition(":")[0] for text in data.attrs["left_out"]] == [
        "spectra/lost.csv", "spectra/c.csv",
    ]  # fmt: skip


def test_a_run_without_tables_is_an_entry_all_the_same(exported):
    entry = exported()

    assert entry["title"].asstr()[()] == "map" and "default" not in entry.attrs


@pytest.mark.parametrize(
    ("axis", "is_even"),
    [
        (np.linspace(190, 950, 22_801).round(4), True),
        (np.linspace(190, 950, 22_801).astype("f4").astype(float), True),
        (np.array([200.0, 201.0, 203.0]), False),
        (np.array([200.0]), False),
        ((190 + 0.03 * np.arange(2048) + 1e-7 * np.arange(2048.0) ** 2).round(4), False),
    ],
)
def test_an_axis_that_is_even_but_for_its_rounding_is_made_even_for_hyperspy(axis, is_even):
    """HyperSpy's reader compares every step with the first, to 1e-5, and else forgets the axis."""
    made = _evened(axis)
    steps = np.diff(made)

    assert np.array_equal(made, axis) or is_even
    assert bool(steps.size and np.allclose(steps[0], steps, rtol=1e-5)) == is_even
    assert np.abs(made - axis).max() < 1e-4
