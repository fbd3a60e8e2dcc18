import numpy as np
import pytest

from labrun.reduction.maps.points.predominant import predominant_peaks
from labrun.reduction.maps.points.reduced import read_reduced
from labrun.reduction.spectrum.fault import Unreadable

PEAKS = "spectrum,center_nm,area,area_err,element,stage,line_nm\n"
ELEMENTS = "spectrum,element,status,area,line_nm\n"
PLASMA = "spectrum,temperature_k,temperature_err,log10_ne\n"
LITHIUM = "a.csv,670.79,100,2,Li,1,670.78\na.csv,610.37,60,3,Li,1,610.36\n"


def tables(tmp_path, **texts):
    for name, text in texts.items():
        (tmp_path / f"{name}.csv").write_text(text)
    return read_reduced(tmp_path)


def test_without_tables_there_is_nothing(tmp_path):
    assert read_reduced(tmp_path) is None


def test_tables_lie_in_the_folder_or_in_reduced(tmp_path):
    (tmp_path / "reduced").mkdir()
    (tmp_path / "reduced" / "plasma.csv").write_text(PLASMA + "a.csv,9000,100,17\nb.csv,,,\n")
    found = tables(tmp_path, peaks=PEAKS + LITHIUM)

    assert found.spectra == ["a.csv", "b.csv"]
    assert found.temperature_k[0] == 9000 and np.isnan(found.temperature_k[1])


def test_an_older_table_is_named_with_what_to_do(tmp_path):
    with pytest.raises(
        Unreadable, match=r"peaks\.csv has no column 'area_err'.*reduce the spectra"
    ):
        tables(tmp_path, peaks="spectrum,center_nm,area,element\n")


def test_the_usual_line_stands_for_an_element(tmp_path):
    peak = predominant_peaks(tables(tmp_path, peaks=PEAKS + LITHIUM))["Li"]

    assert (peak.line_nm, peak.area.tolist(), peak.area_error.tolist()) == (670.78, [100], [2])


def test_another_line_does_where_the_usual_one_is_not_seen(tmp_path):
    text = PEAKS + "a.csv,610.37,60,3,Li,1,610.36\na.csv,460.3,5,1,Li,1,460.29\n"

    assert predominant_peaks(tables(tmp_path, peaks=text))["Li"].line_nm == 610.36


def test_every_spectrum_is_told_by_the_same_line(tmp_path):
    """b.csv shows its brightest lithium at 610 nm; the map is of 670 nm, where it has a faint one."""
    more = "b.csv,610.37,500,3,Li,1,610.36\nb.csv,670.8,7,1,,,\nc.csv,300,9,1,Al,1,300\n"
    peak = predominant_peaks(tables(tmp_path, peaks=PEAKS + LITHIUM + more))["Li"]

    assert peak.area.tolist() == [100, 7, 0]


def test_a_peak_of_another_element_is_not_taken_for_this_one(tmp_path):
    more = "b.csv,670.79,50,1,Ca,1,670.79\n"
    peak = predominant_peaks(tables(tmp_path, peaks=PEAKS + LITHIUM + more))["Li"]

    assert peak.area.tolist() == [100, 0]


def test_an_instrument_that_counts_in_vacuum_is_understood(tmp_path):
    text = PEAKS + "a.csv,670.97,100,2,Li,1,670.96\na.csv,610.5,60,3,Li,1,610.53\n"

    assert predominant_peaks(tables(tmp_path, peaks=text))["Li"].line_nm == 670.96


def test_the_elements_table_goes_first_and_takes_its_errors_from_the_peaks(tmp_path):
    elements = ELEMENTS + "a.csv,Li,detected,100,670.78\nb.csv,Li,absent,0,670.78\n"
    peak = predominant_peaks(tables(tmp_path, peaks=PEAKS + LITHIUM, elements=elements))["Li"]

    assert peak.area.tolist() == [100, 0]
    assert peak.area_error[0] == 2


def test_a_spectrum_that_failed_is_a_hole_and_no_zero(tmp_path):
    files = "spectrum,status\na.csv,reduced\nb.csv,failed\n"
    peak = predominant_peaks(tables(tmp_path, peaks=PEAKS + LITHIUM, files=files))["Li"]

    assert peak.area[0] == 100 and np.isnan(peak.area[1])
