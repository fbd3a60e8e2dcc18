"""What is known of the time that an iteration will take, before it begins."""

import pytest

from labrun.engine.check import check_file
from labrun.engine.run.frame import Results
from labrun.engine.tree.legs import Legs

PROTOCOL = """labrun: 1
name: t
devices: {furnace: furnace@1, balance: balance@1, libs: libs_analyzer@1}
steps:
"""
USED = """labrun: 1
name: used
devices: {furnace: furnace@1}
params: {time: {type: quantity, unit: s, default: 1 min}}
steps: [{do: furnace.hold, with: {duration: "${{ params.time }}"}}]
"""
HOLD = 'do: furnace.hold, with: {duration: "${{ %s }}"}'
BEFORE = Results()
BEFORE.own["before"] = {"time": 40}
F, B, L = "furnace", "balance", "libs"


@pytest.fixture
def known(tmp_path):
    """Steps -> the legs of them, devices and seconds, for the item `s`."""
    (tmp_path / "used.yaml").write_text(USED)

    def legs(steps, item):
        path = tmp_path / "t.yaml"
        path.write_text(PROTOCOL + steps)
        survey = check_file(path, params={}, needed=True).survey
        assert survey is not None
        found = Legs(survey).of(survey.protocol.steps, {"s": item, "steps": Results(BEFORE)})
        return [("+".join(sorted(devices)), seconds) for devices, seconds in found]

    return legs


@pytest.mark.parametrize(
    ("steps", "item", "legs"),
    [
        ("- {%s}" % (HOLD % "s"), "2 h", [(F, 7200.0)]),
        ("- {%s}" % (HOLD % "s * 60"), 2, [(F, 120.0)]),
        ("- {%s}" % (HOLD % "steps.w.time"), 2, [(F, 3600.0)]),  # typical, by its contract
        ("- {%s}" % (HOLD % "steps.before.time"), 2, [(F, 40.0)]),
        ("- {do: balance.weigh}\n- {do: balance.weigh}", 0, [(B, 6.0)]),
        ("- {do: furnace.off}", 0, [("", 1.0)]),  # meanwhile: it keeps nobody waiting
        ("- {wait: '${{ s }}'}\n- {wait: {until: '07:00'}}", 30, [("", 30.0)]),
        ("- {set: {t: '${{ s + s }}'}}\n- {%s}" % (HOLD % "t"), 5, [(F, 10.0)]),
        ("- {when: '${{ s > 1 }}', do: balance.weigh}", 1, []),
        ("- {when: '${{ steps.w.wet }}', do: balance.weigh}", 1, [(B, 3.0)]),
        ("- {if: '${{ s > 1 }}', then: [{do: balance.weigh}], else: [{do: libs.measure}]}", 1, [(L, 8.0)]),
        ("- {repeat: '${{ s }}', steps: [{do: balance.weigh}]}", 3, [(B, 9.0)]),
        ("- {foreach: {t: '${{ s }}'}, steps: [{%s}]}" % (HOLD % "t"), [1, 2], [(F, 3.0)]),
        ("- {while: '${{ s > 0 }}', max: 9, steps: [{do: balance.weigh}]}", 3, [(B, 3.0)]),
        ("- parallel: [{do: balance.weigh}, {do: libs.measure}]", 0, [("balance+libs", 8.0)]),
        ("- {reserve: [libs], steps: [{do: libs.measure}, {do: balance.weigh}]}", 0, [("balance+libs", 11)]),
        ("- {steps: [{do: balance.weigh}, {do: libs.measure}]}", 0, [(B, 3.0), (L, 8.0)]),
        ("- {use: used.yaml, with: {time: '${{ s }}'}}", "2 min", [(F, 120.0)]),
        ("- {use: used.yaml}", 0, [(F, 60.0)]),
    ],
)  # fmt: skip
def test_legs(known, steps, item, legs):
    assert known(steps, item) == legs
