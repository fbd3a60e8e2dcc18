"""How long a protocol will take: as earlier runs did, or as contracts say, on a twin's quicker clock."""

import pytest

from labrun.engine.check import check_text
from labrun.web.library.timings import Timings
from labrun.web.library.views import preview_of

TEXT = """\
labrun: 1
name: far
devices: {gantry: gantry@1}
steps: [{do: gantry.home, timeout: 1 min}, {do: gantry.move_to, with: {x: 5 mm}, timeout: 1 min}]
"""
ASKING = """\
  - {confirm: argon on?, when: "${{ not run.simulated }}"}
  - {if: "${{ run.simulated }}", then: [{confirm: only practising?}], else: [{confirm: for real?}]}
  - {confirm: 'run ${{ run.id }} now?'}
"""
LAB = """\
name: own
simulated: %s
devices: {gantry: {contract: gantry@1, driver: sim_gantry, config: {clock: %s}}}
"""


@pytest.mark.parametrize(
    ("simulated", "clock", "seconds"),
    [("true", "real", 22), ("true", "50", 0.44), ("true", "fast", 0), ("false", "50", 22)],
)
def test_twins_are_as_quick_as_their_clock(tmp_path, simulated, clock, seconds):
    (tmp_path / "lab.yaml").write_text(LAB % (simulated, clock))
    checked = check_text(TEXT, str(tmp_path / "far.yaml"), lab=tmp_path / "lab.yaml")
    timings = Timings(tmp_path / "timings.json")
    before = preview_of(checked, timings).time_s
    timings.learn("r1", {"gantry.home": [4.0, 6.0], "gantry.move_to": [1.0]})
    after = preview_of(checked, timings).time_s

    assert (before.low, before.runs) == (pytest.approx(seconds), 0)
    assert after.runs == 1 and 4 < after.low < after.high < 8


@pytest.mark.parametrize(
    ("simulated", "asked"), [("true", ["only practising?"]), ("false", ["argon on?", "for real?"])]
)
def test_a_preview_lists_the_questions_that_this_lab_will_ask(tmp_path, simulated, asked):
    (tmp_path / "lab.yaml").write_text(LAB % (simulated, "real"))
    text = TEXT.split("steps:")[0] + "steps:\n" + ASKING
    checked = check_text(text, str(tmp_path / "far.yaml"), lab=tmp_path / "lab.yaml")
    told = preview_of(checked, Timings(tmp_path / "timings.json")).needs_you

    assert told[:-1] == asked and told[-1].startswith("run ")
