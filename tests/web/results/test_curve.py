"""The picture of a calibration curve that a line's click asks for."""

import shutil
from pathlib import Path

import pytest

from labrun.web.local.refusal import Refusal
from labrun.web.results.curve_work import curve

SIMULATED = Path(__file__).parents[3] / "protocols" / "simulated.calibration"


def test_the_curve_of_an_element_is_that_of_the_calibration_that_the_run_used(tmp_path):
    used = tmp_path / "used"
    used.mkdir()
    (used / "0-other.calibration").write_text("{}")
    shutil.copy(SIMULATED, used / "1-simulated.calibration")
    svg = curve({"folder": str(tmp_path), "element": "Li"})["svg"]

    assert svg.startswith("<?xml") and "Date" not in svg
    assert svg == curve({"folder": str(tmp_path), "element": "Li"})["svg"]
    for folder, element in ((tmp_path, "Xe"), (used, "Li")):
        with pytest.raises(Refusal) as refused:
            curve({"folder": str(folder), "element": element})
        assert refused.value.status == 404
