"""Check standards whose readings are known to hold, to be off, or to drift."""

import csv

import numpy as np
import pytest

from labrun.reduction.figures.control_chart import control_chart
from labrun.reduction.mapping.report import make
from labrun.reduction.maps.checks import Checks, read_checks


def readings(rng, n=8, off=0.0, drift=0.0, scatter=0.05, error=0.3):
    """Of 2 wt %: `off` in errors, which all share, `drift` as a part from first to last."""
    found = (2 + off * error) * (1 + drift * np.linspace(0, 1, n)) + scatter * rng.normal(size=n)
    return Checks("BHVO-2", "Li", found, np.full(n, error), 2.0, 0.0)


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
