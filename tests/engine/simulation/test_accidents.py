"""Accidents that came out of simulated histories, each by itself."""

import asyncio
import json

import pytest

from labrun.engine.check import check_file
from labrun.engine.simulation import instrument
from labrun.engine.simulation.history import History, Outcome, compare, place_of_goal
from labrun.engine.simulation.protocols import ACTIONS


def history(folder, after, accident, **contract):
    """One device `a`; `accident(history)` happens half a second after the end of a step."""
    told = {"type": "a@1", "on_lease_lapse": "safe", "actions": ACTIONS, **contract}
    (folder / "a.json").write_text(json.dumps(told))
    devices = {"a": {"contract": "a@1", "url": "http://a"}}
    lab = {"name": "l", "simulated": True, "contracts": ["./a.json"], "devices": devices}
    (folder / "lab.json").write_text(json.dumps(lab))
    steps = [
        {"id": "set", "do": "a.set", "with": {"n": 1, "to": 1}},
        {"wait": "1 s"},
        {"id": "shot", "do": "a.fire"},
    ]
    protocol = {"labrun": 1, "name": "p", "devices": {"a": "a@1"}, "steps": steps}
    (folder / "p.json").write_text(json.dumps(protocol))
    checked = check_file(folder / "p.json", lab=folder / "lab.json")
    assert checked.ok, checked.problems

    class Struck(History):
        once = True

        def _heard(self, event):
            super()._heard(event)
            about = (event.event, event.path, event.state)
            if self.once and about == ("goal", f"main/{after}", "succeeded"):
                self.once = False
                asyncio.get_running_loop().call_later(0.5, accident, self)

    return Struck(checked, 1, accidents=0, ledgers=False)


@pytest.mark.parametrize(
    ("away_s", "clock_s"), [(45, 0), (45, -30), (45, -3600), (5, 0), (5, 3600), (15, -20)]
)
def test_what_was_set_is_set_again_only_if_the_lease_has_lapsed_whatever_the_clock_says(
    tmp_path, away_s, clock_s
):
    def gone(lived):
        lived.kill_engine()
        lived.off_until = asyncio.get_running_loop().time() + away_s
        lived.clock_off_s += clock_s

    lived = history(tmp_path, "set", gone)
    outcome = lived.live()
    (shot,) = lived.bench.deeds
    sets = [line for line in outcome.story if "main/set sent" in line]

    assert shot.settings["a"] == {"channel 1": {"n": 1, "to": 1}}
    assert len(sets) == 1 + (away_s > 30)


def test_a_server_that_dies_while_its_device_is_made_safe_is_asked_again_when_it_is_back(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(instrument, "SAFE_S", (3.0,))

    def lost(lived):
        (server,) = lived.servers
        server.kill()
        server.disk.put_back({})

    lived = history(tmp_path, "shot", lost, safe_state=["rest"])
    outcome = lived.live()

    assert outcome.breaches == []


def test_a_turn_within_a_turn_is_the_same_place():
    assert place_of_goal("run/main/1/r2/1/0/r2/1/0/s2/1") == "main/1/0/s2"
    assert place_of_goal("run/main/1/r2/1/s8/1") == "main/1/s8"


@pytest.mark.parametrize(("set_by_the_group", "breaches"), [(9, 0), (7, 1)])
def test_a_turn_finds_what_the_turn_before_has_set_and_nothing_else(set_by_the_group, breaches):
    what, found, undisturbed = "a: channel 2", {"to": 9}, {"to": 2}
    outcome = Outcome(
        0, facts={"main/g/s": {what: found}}, excused={"main/g/s": set()},
        redone={"main/g/s": [(what, {"to": set_by_the_group})]},
    )  # fmt: skip
    compare(outcome, {"main/g/s": {what: undisturbed}})

    assert len(outcome.breaches) == breaches
