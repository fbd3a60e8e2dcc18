"""Concentrations at points, from the tables of a reduction and from a run's own rows."""

import csv

import numpy as np
import pytest

from labrun.reduction.mapping.choices import MapChoices
from labrun.reduction.mapping.report import make
from labrun.reduction.mapping.tables import MAPS, write_maps
from labrun.reduction.maps.points.gather import gather

HEAD = (
    "spectrum,element,status,area,line_nm,wt_percent,wt_percent_err,wt_percent_low,"
    "wt_percent_high,wt_percent_flags\n"
)
CELLS = {  # of Li at the points 0 to 4; K is not calibrated, Rb not measured
    "p_0": "0.5,0.05,0.4,0.61,",
    "p_1": ",,,0.02,below LOD",
    "p_2": "2.5,0.3,2.1,3.0,above range: the standards end at 2 wt %",
    "p_3": ",,2.9,,above range: the standards end at 2 wt %",
    "p_4": ",,,,not measured: its line is full",
}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "reduced").mkdir()
    rows = "".join(
        f"{name}.csv,Li,detected,5,670.8,{cells}\n{name}.csv,K,detected,7,766.5,,,,,\n"
        for name, cells in CELLS.items()
    )
    (tmp_path / "reduced" / "elements.csv").write_text(HEAD + rows)
    places = "".join(f"{k},{k % 3},{k // 3},p_{k}.csv\n" for k in range(5))
    (tmp_path / "data.csv").write_text(f"key,x,y,spectrum\n{places}5,2,1,gone.csv\n")
    return tmp_path


def test_a_value_a_limit_and_nothing_are_three_things(folder):
    found = gather(folder).contents

    assert list(found) == ["Li"]
    li = found["Li"]
    assert li.value[:3] == pytest.approx([0.5, np.nan, 2.5], nan_ok=True)
    assert li.covered.tolist() == [True, False, False, False, False, False]
    assert li.below.tolist() == [False, True, False, False, False, False]
    assert li.above.tolist() == [False, False, True, True, False, False]
    assert li.high[1] == 0.02 and li.low[3] == 2.9


def test_the_table_of_a_map_says_all_of_it(folder, tmp_path):
    path = write_maps(gather(folder), ["K"], MapChoices(), tmp_path)
    rows = list(csv.DictReader(path.read_text().splitlines()))
    li = [row for row in rows if row["element"] == "Li"]

    assert path.name == MAPS
    assert [row["wt_percent"] for row in li] == ["0.5", "", "2.5", "", "", ""]
    assert li[1]["wt_percent_high"] == "0.02" and li[1]["wt_percent_flags"] == "below LOD"
    assert {row["wt_percent"] for row in rows if row["element"] == "K"} == {""}


def test_two_shots_at_a_place_have_their_mean_or_the_ends_that_hold_both(folder):
    text = (folder / "data.csv").read_text().replace("1,1,0,", "1,0,0,").replace("3,0,1,", "3,2,0,")
    (folder / "data.csv").write_text(text)
    li = gather(folder).contents["Li"]

    assert np.isnan(li.value[0]) and li.high[0] == 0.61 and li.below[0]
    assert np.isnan(li.value[1]) and li.low[1] == 2.1 and li.above[1] and np.isnan(li.high[1])


def test_a_run_that_collected_concentrations_has_their_maps(tmp_path):
    head = "key,x,y,Li_wt_percent,Li_wt_percent_err,Li_wt_percent_low,Li_wt_percent_high\n"
    cells = ["0.5,0.05,0.4,0.61", ",,,0.02", ",,2.9,", ",,,"]
    rows = [f"{k},{k % 2},{k // 2},{one}\n" for k, one in enumerate(cells)]
    (tmp_path / "data.csv").write_text(head + "".join(rows))
    li = gather(tmp_path, tables=False).contents["Li"]

    assert li.covered.tolist() == [True, False, False, False]
    assert li.below.tolist() == [False, True, False, False]
    assert li.above.tolist() == [False, False, True, False]
    assert [path.name for path in make(tmp_path)] == ["concentrations.png"]
