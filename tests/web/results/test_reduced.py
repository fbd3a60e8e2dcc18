"""Tables of the reduction, joined to the points of their run."""

from labrun.web.results.reduced import places, read_reduced, reduced_names
from labrun.web.results.tables import read_table

DATA = "key,x_mm,y_mm,fate\na,0,5,succeeded\nb,1,5,succeeded\n"
PLASMA = "spectrum,temperature_k\nspectra/b.csv,9000\nspectra/stray.csv,1\n"
MAPS = """\
sample,point,x_mm,y_mm,element,line_nm,value,area,area_err
,spectra/a.csv,0,5,Li,670.8,0.5,10,1
,spectra/b.csv,1,5,Li,670.8,1,20,1
,spectra/b.csv,1,5,K,766.5,1,3,1
"""
CLASSES = "sample,point,x_mm,y_mm,class\n,spectra/a.csv,0,5,none\n,spectra/b.csv,1,5,2\n"


def joined(folder, name, text):
    (folder / "data.csv").write_text(DATA)
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_text(text)
    spectra = [("spectra/a.csv", "a"), ("spectra/b.csv", "b"), ("spectra/dark.csv", None)]
    points = places(spectra, [read_table(folder, "data.csv")])
    return read_reduced(folder, name, points)


def test_a_spectrum_gets_the_key_and_the_place_of_its_point(tmp_path):
    table = joined(tmp_path, "reduced/plasma.csv", PLASMA)

    assert table.columns == {
        "key": ["b", ""], "x_mm": ["1", ""], "y_mm": ["5", ""],
        "spectrum": ["spectra/b.csv", "spectra/stray.csv"], "temperature_k": ["9000", "1"],
    }  # fmt: skip


def test_areas_of_elements_become_columns_and_a_missing_one_stays_empty(tmp_path):
    table = joined(tmp_path, "maps/maps.csv", MAPS)

    assert table.columns["key"] == ["a", "b"] and table.columns["x_mm"] == ["0", "1"]
    assert table.numbers["Li"] == [10, 20] and table.numbers["K"] == [None, 3]
    assert "value" not in table.columns


def test_a_point_without_a_class_is_a_hole(tmp_path):
    table = joined(tmp_path, "maps/classes.csv", CLASSES)

    assert table.numbers["class"] == [None, 2]
    assert reduced_names(tmp_path) == ["maps/classes.csv"]


def test_an_empty_table_has_no_points(tmp_path):
    assert joined(tmp_path, "maps/classes.csv", "").rows == 0
