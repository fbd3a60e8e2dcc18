"""The committed table of lines is what its committed script makes, and small enough to ship."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import labrun.reduction.data
from labrun.reduction.lines import compile_lines
from labrun.reduction.lines.table import COLUMNS

DATA = Path(labrun.reduction.data.__file__).parent
MORE = 833  # of more_lines.csv
NIST_CLASSES = {"AAA", "AA", "A+", "A", "B+", "B", "C+", "C", "D+", "D", "E"}


@pytest.fixture(scope="module")
def committed():
    with np.load(DATA / "lines.npz", allow_pickle=False) as table:
        return {name: table[name] for name in table.files}


def test_the_table_is_under_two_megabytes():
    assert (DATA / "lines.npz").stat().st_size < 2_000_000


@pytest.mark.skipif(importlib.util.find_spec("libskit") is None, reason="libskit 0.2 is not here")
def test_the_script_makes_exactly_the_table_that_is_committed(committed):
    folder = compile_lines.libskit_data()
    lines, left_out = compile_lines.compile_lines(folder)
    made = {
        **{name: getattr(lines, name) for name in COLUMNS},
        **compile_lines.compile_species(folder),
    }

    assert set(made) == set(committed)
    for name, array in made.items():
        assert np.array_equal(array, committed[name], equal_nan=array.dtype.kind == "f"), name
    assert sum(left_out.values()) + len(lines) - MORE == 142_597


def test_no_line_is_there_twice(committed):
    rows = zip(*(committed[name].tolist() for name in (
        "element", "stage", "wavelength_nm", "e_i_ev", "e_k_ev", "g_i", "g_k"
    )), strict=True)  # fmt: skip

    assert len(set(rows)) == 29_833 + MORE


def test_each_line_keeps_the_class_that_nist_gives_it(committed):
    classes = {name.rstrip("'") for name in committed["accuracy"].tolist()}

    assert classes == {*NIST_CLASSES, ""}
    assert np.mean(committed["accuracy"] != "") > 0.97


@pytest.mark.parametrize(
    ("element", "stage", "ionisation_ev"),
    [
        ("Li", 1, 5.3917),
        ("K", 1, 4.3407),
        ("Si", 2, 16.3458),
        ("Ca", 2, 11.8717),
        ("H", 1, 13.5984),
    ],
)
def test_ionisation_energies_are_those_of_nist(committed, element, stage, ionisation_ev):
    row = (committed["species_element"] == element) & (committed["species_stage"] == stage)

    assert committed["species_ionisation_ev"][row] == pytest.approx([ionisation_ev], abs=1e-3)


def test_the_sources_are_cited_with_the_tables_own_numbers(committed):
    page = (DATA / "SOURCES.md").read_text(encoding="utf-8")

    assert "NIST Atomic Spectra Database" in page and "STARK-B" in page and "libskit" in page
    assert f"**{len(committed['element']):,}**" in page
    assert f"**{len(committed['level_ev']):,}**" in page
