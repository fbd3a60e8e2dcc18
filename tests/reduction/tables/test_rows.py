"""Rows against the truth that the spectra were made of, and against what a reduction says."""

import numpy as np
import pyarrow as pa
import pytest
from scipy.special import voigt_profile

from labrun.reduction import Spectrum, reduce_spectrum
from labrun.reduction.tables.arrow import table_of
from labrun.reduction.tables.columns import TABLES
from labrun.reduction.tables.element_rows import element_rows
from labrun.reduction.tables.named import names
from labrun.reduction.tables.peak_rows import heights, peak_rows
from labrun.reduction.tables.plasma_rows import plasma_row
from labrun.reduction.tables.rows import packed, rows_of, unpacked


@pytest.fixture(scope="module")
def found(reduced):
    """A spectrum of the independent generator, its truth, and its reduction."""
    truth, reduction = reduced("train", 3)
    return Spectrum(truth.wavelength_nm, truth.intensity), truth, reduction


def column(cells, name):
    return np.asarray(cells[name])


def test_a_height_is_the_top_of_its_profile():
    area, sigma, gamma = np.array([10.0, 10.0, 3.0]), np.array([0.05, 0.05, 0.1]), [0.0, 0.02, 0.3]

    assert heights(area, sigma, np.array(gamma)) == pytest.approx(
        area * voigt_profile(0.0, sigma, gamma), rel=1e-4
    )


def test_peaks_ascend_and_say_what_the_reduction_says(found):
    spectrum, _, reduction = found
    cells = peak_rows(spectrum.wavelength_nm, reduction)

    assert list(cells) == [c.name for c in TABLES["peaks"][1:]]
    assert np.all(np.diff(column(cells, "center_nm")) >= 0)
    assert column(cells, "area").tolist() == reduction.peaks.area.tolist()
    assert np.all(column(cells, "snr") > 0)


def test_named_peaks_are_near_their_lines_and_only_of_elements_that_were_found(found):
    spectrum, _, reduction = found
    cells = peak_rows(spectrum.wavelength_nm, reduction)
    named = np.array([bool(name) for name in cells["element"]])
    away = column(cells, "center_nm")[named] - column(cells, "line_nm")[named]
    told = {name for name in cells["element"] if name}

    assert named.sum() > 0.5 * len(named)
    assert np.abs(away).max() < 0.3
    assert all(reduction.evidence[name].status != "absent" for name in told)
    assert [bool(stage) for stage in cells["stage"]] == named.tolist()


def test_most_names_are_those_of_the_line_that_made_the_peak(found):
    _, truth, reduction = found
    named = names(reduction)
    right = wrong = 0
    for k, centre in enumerate(reduction.peaks.centre_nm):
        near = np.abs(truth.groups.shown_nm - centre) < 0.03
        if not named.element[k] or not near.any():
            continue
        strongest = truth.groups.element[near][np.argmax(truth.groups.area[near])]
        right += named.element[k] == strongest
        wrong += named.element[k] != strongest

    assert right > 20
    assert right > 9 * wrong


def test_every_element_has_a_row_and_its_status_is_the_evidence(found):
    spectrum, _, reduction = found
    cells = element_rows(spectrum.wavelength_nm, reduction)
    status = dict(zip(cells["element"], cells["status"], strict=True))

    assert {n for n, s in status.items() if s == "detected"} == set(reduction.detected)
    assert set(reduction.evidence) <= set(status)
    assert cells["element"] == sorted(cells["element"])


def test_areas_of_elements_asked_for_are_those_of_their_predominant_lines(found):
    spectrum, _, reduction = found
    cells = element_rows(spectrum.wavelength_nm, reduction)
    area = dict(zip(cells["element"], cells["area"].tolist(), strict=True))

    within = [n for n, e in reduction.elements.items() if e.fate != "outside the spectrum"]

    assert len(within) > 3
    assert {name: area[name] for name in within} == {n: reduction.areas[n] for n in within}
    assert np.all(column(cells, "detection_limit")[column(cells, "area") > 0] > 0)


def test_lines_are_told_as_tables_have_them_not_as_the_instrument_shows_them(found):
    spectrum, _, reduction = found
    cells = element_rows(spectrum.wavelength_nm, reduction, ["Na", "Ca"])

    assert cells["element"] == ["Na", "Ca"]
    places = {"air": (588.995, 393.366), "vacuum": (589.158, 393.478)}[reduction.medium]
    assert cells["line_nm"] == pytest.approx(places, abs=0.02)


def test_an_element_without_a_line_in_the_spectrum_is_absent_with_empty_cells():
    rng = np.random.default_rng(2)
    x = np.linspace(200.0, 300.0, 3000)
    spectrum = Spectrum(x, 100 + rng.normal(0, 3, len(x)))
    cells = element_rows(x, reduce_spectrum(spectrum, ["Li", "Mg"]), ["Li", "Mg"])

    assert cells["status"] == ["absent", "absent"]
    assert np.isnan(cells["area"]).tolist() == [True, False]
    assert np.isnan(cells["detection_limit"]).tolist() == [True, False]
    assert cells["line_nm"][1] == pytest.approx(279.553, abs=0.01)


def test_a_spectrum_that_tells_nothing_of_its_plasma_has_an_empty_row():
    rng = np.random.default_rng(2)
    x = np.linspace(200.0, 300.0, 3000)
    reduction = reduce_spectrum(Spectrum(x, 100 + rng.normal(0, 3, len(x))))

    assert plasma_row(reduction)["temperature_k"] == [None]
    assert plasma_row(reduction)["method"] == [""]


def test_saturated_and_bad_channels_are_flagged_on_the_peaks_that_they_touch():
    rng = np.random.default_rng(2)
    x = np.linspace(580.0, 600.0, 2000)
    y = 100 + rng.normal(0, 2, len(x))
    y += 900 * voigt_profile(x - 588.995, 0.04, 0.01) + 500 * voigt_profile(x - 595.0, 0.04, 0.01)
    y = np.minimum(y, 4000.0)
    y[np.searchsorted(x, 595.06)] = np.nan
    spectrum = Spectrum(x, y)
    cells = peak_rows(x, reduce_spectrum(spectrum))
    flags = {round(c): f for c, f in zip(cells["center_nm"], cells["flags"], strict=True)}

    assert "saturated" in flags[589]
    assert "bad channel" in flags[595]


def test_rows_are_packed_and_unpacked_without_loss(found):
    spectrum, _, reduction = found
    rows = unpacked(packed(rows_of(spectrum, reduction)))
    peaks = table_of("peaks", [("a/b.csv", rows["peaks"])])

    assert set(rows) == set(TABLES)
    assert len(peaks) == reduction.n_peaks
    assert set(peaks["spectrum"].to_pylist()) == {"a/b.csv"}
    assert peaks["center_nm"].to_pylist() == pytest.approx(reduction.peaks.centre_nm, abs=1e-5)


def test_rows_of_many_spectra_are_those_of_each_one_after_the_other(found):
    spectrum, _, reduction = found
    for table, cells in rows_of(spectrum, reduction).items():
        several = table_of(table, [("a.csv", cells), ("b.csv", cells)])
        one_by_one = pa.concat_tables(table_of(table, [(n, cells)]) for n in ("a.csv", "b.csv"))

        assert several.equals(one_by_one)
    with pytest.raises(ValueError, match="the cells of plasma are"):
        table_of("plasma", [("a.csv", {"temperature_k": [1.0]})])
