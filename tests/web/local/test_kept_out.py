"""Boxes that a machine keeps out of are told as the lab has them written."""

import pytest

from labrun.engine.check import check_text
from labrun.web.library.timings import Timings
from labrun.web.library.views import preview_of
from labrun.web.local.kept_out import kept_out

LAB = """\
name: clamped
devices:
  gantry:
    contract: gantry@1
    driver: sim_gantry
    config: {{keep_out: {boxes}}}
"""
SCAN = """\
labrun: 1
name: scan
devices: {gantry: gantry@1}
steps: [{do: gantry.move_to, with: {x: 5 mm, y: 5 mm}}]
"""


@pytest.fixture
def checked(tmp_path):
    """Checks a scan with these boxes written in the lab."""

    def check(boxes):
        (tmp_path / "lab.yaml").write_text(LAB.format(boxes=boxes))
        return check_text(SCAN, "scan.yaml", lab=tmp_path / "lab.yaml")

    return check


def test_a_preview_has_the_boxes_of_its_machine_as_they_were_written(checked, tmp_path):
    looked = checked("[{name: clamp, x: [100, 140], y: [50, 100], z: [0, 35]}, {x: [600, 730]}]")
    (track,) = preview_of(looked, Timings(tmp_path / "timings.json")).tracks
    clamp, other = track.keep_out

    assert clamp.name == "clamp"
    assert (clamp.x0, clamp.x1, clamp.y0, clamp.y1, clamp.z0, clamp.z1) == (
        100,
        140,
        50,
        100,
        0,
        35,
    )
    assert (other.x0, other.x1) == (600, 730)
    assert (other.y0, other.y1, other.z0, other.z1) == (None,) * 4


@pytest.mark.parametrize("boxes", ["3", "[4]", "[{x: [5, 1]}]", "[{w: [0, 1]}]", "[]"])
def test_boxes_that_are_wrong_are_not_drawn_and_hide_nothing_else(checked, tmp_path, boxes):
    looked = checked(boxes)

    assert kept_out(looked.lab, "gantry") == []
    assert kept_out(looked.lab, "none") == kept_out(None, "gantry") == []
    assert preview_of(looked, Timings(tmp_path / "timings.json")).tracks[0].x_mm == [5]
