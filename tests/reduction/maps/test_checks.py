"""Check standards whose readings are known to hold, to be off, or to drift."""

import csv

import numpy as np
import pytest

from labrun.reduction.figures.control_chart import control_chart
from labrun.reduction.mapping.choices import MapChoices
from labrun.reduction.mapping.folder import map_folder
from labrun.reduction.mapping.report import make
from labrun.reduction.maps.checks import Checks, read_checks
from labrun.reduction.maps.drift import drift_of
from labrun.reduction.maps.points.gather import gather


def readings(rng, n=8, off=0.0, drift=0.0, scatter=0.05, error=0.3):
    """Of 2 wt %: `off` in errors, which all share, `drift` as a part from first to last."""
    found = (2 + off * error) * (1 + drift * np.linspace(0, 1, n)) + scatter * rng.normal(size=n)
    return Checks("BHVO-2", "Li", found, np.full(n, error), 2.0, 0.0, np.arange(n) * 10.0)


def test_a_calibration_holds_as_often_as_its_errors_say():
    rng = np.random.default_rng(5)
    drawn = [readings(rng, off=rng.normal()) for _ in range(400)]
    held = np.mean([abs(one.off) <= 2 for one in drawn if one.off is not None])

    assert 0.92 < held < 0.98
    assert sum(one.drifts for one in drawn) <= 10  # of 400 without a drift, by chance 4


def test_what_is_off_or_drifts_is_said():
    rng = np.random.default_rng(6)

    assert readings(rng).holds
    assert "the calibration holds; no drift is seen" in readings(rng).sentence
    far = readings(rng, off=3.5)
    assert not far.holds and "errors off, the calibration does not hold" in far.sentence
    falls = readings(rng, drift=-0.2)
    assert not falls.holds
    assert "within errors, but the instrument drifts; it falls by 17 %" in falls.sentence
    few = readings(rng, n=3)
    assert few.drift is None and "4 checks or more would tell a drift" in few.sentence


def test_a_run_s_checks_become_a_table_and_charts(tmp_path):
    rows = "0,BHVO-2,2.1,0.3,2.0\n1,BHVO-2,,,2.0\n2,BHVO-2,1.9,0.3,2.0\n3,blank,,,0\n"
    (tmp_path / "data-scan-check.csv").write_text(
        "key,standard,Li_wt_percent,Li_wt_percent_err,Li_wt_percent_known\n" + rows
    )
    written = make(tmp_path)
    told = list(csv.DictReader((tmp_path / "checks.csv").read_text().splitlines()))

    assert [path.name for path in written] == ["checks.csv", "checks.png"]
    assert [row["holds"] for row in told] == ["yes", "no"]
    assert told[0]["verdict"].startswith(
        "BHVO-2: Li reads 2 ± 0.3 wt % (mean of 2, 1 told none; error of one), where 2 is known"
    )
    assert told[1]["verdict"] == "blank: Li told no value in 1 checks, where 0 wt % is known"
    assert len(control_chart(read_checks(tmp_path)).axes) == 2


def test_a_run_without_checks_has_none(tmp_path):
    (tmp_path / "data.csv").write_text("key,x,y,Li\n0,0,0,5\n")

    assert read_checks(tmp_path) == []
    with pytest.raises(ValueError, match="no check"):
        control_chart([])


def run(folder, points, drift=-0.2, correct="", column="point"):
    """A run of points of 3 wt % that fall by a part from first to last, with a check every five."""
    rng = np.random.default_rng(4)
    left = 1 + drift * np.arange(points) / (points - 1)
    found = 3 * left * (1 + 0.005 * rng.normal(size=points))
    rows = [f"{k},{k % 5},{k // 5},50,{c:.5f},0.3,{c + 0.6:.5f}" for k, c in enumerate(found)]
    head = "key,x,y,Li,Li_wt_percent,Li_wt_percent_err,Li_wt_percent_high"
    (folder / "data.csv").write_text("\n".join([head, *rows]))
    checks = [
        f"BHVO-2,{k},{2 * left[k] * (1 + 0.003 * rng.normal()):.5f},0.2,2,{correct}"
        for k in range(0, points, 5)
    ]
    head = f"standard,{column},Li_wt_percent,Li_wt_percent_err,Li_wt_percent_known,correct_drift"
    (folder / "data-scan-check.csv").write_text("\n".join([head, *checks]))
    return folder


def test_the_slope_of_a_drift_and_its_error_are_those_of_the_readings():
    rng = np.random.default_rng(8)
    found = [drift_of(readings(rng, n=12, drift=-0.2, scatter=0.02)) for _ in range(200)]
    off = [(one.slope * 110 + 0.2) / (one.error * 110) for one in found if one is not None]

    assert len(off) == 200
    assert 0.85 < np.std(off) < 1.3 and abs(np.mean(off)) < 0.3
    assert drift_of(readings(rng, n=12)) is None


def test_a_map_is_corrected_when_asked_and_says_so(tmp_path):
    folder = run(tmp_path, 40)
    before, after = (gather(folder, correct_drift=asked).contents["Li"] for asked in (False, True))
    result = map_folder(folder, tmp_path / "maps", MapChoices(n_classes=1, correct_drift=True))
    rows = list(csv.DictReader((tmp_path / "maps" / "maps.csv").read_text().splitlines()))
    told = [row for row in rows if row["element"] == "Li"]

    assert before.value[-1] == pytest.approx(2.4, rel=0.02)
    assert after.value == pytest.approx(np.full(40, 3.0), rel=0.03)
    assert after.value.std() < 0.25 * before.value.std()
    assert after.error[-1] > before.error[-1] * 1.2
    assert {row["wt_percent_flags"] for row in told} == {"drift corrected"}
    assert any(
        note.startswith("Li: corrected for drift by BHVO-2 (8 checks): times 1 at")
        for note in result.notes
    )


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"drift": 0.0}, "no drift is seen (BHVO-2)"),
        ({"column": "place"}, "its rows have no column `point`"),
    ],
)
def test_what_is_not_corrected_is_said(tmp_path, asked, said):
    points = gather(run(tmp_path, 40, **asked), correct_drift=True)

    assert any("Li: not corrected for drift, " in note and said in note for note in points.notes)
    assert not any("drift" in str(flag) for flag in points.contents["Li"].flags)


def test_a_run_asks_for_it_in_the_rows_of_its_checks(tmp_path):
    assert gather(run(tmp_path, 40, correct="true")).contents["Li"].flags[-1] == "drift corrected"
    (tmp_path / "data-scan-check.csv").unlink()

    assert (
        "not corrected for drift: no rows of check standards"
        in gather(tmp_path, correct_drift=True).notes
    )
