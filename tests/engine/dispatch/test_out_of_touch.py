"""A `once` action waits for another device that is out of touch, no longer than a setting, and says so."""

import json

import pytest

from labrun.engine.check import check_file
from labrun.engine.dispatch.dispatcher import Dispatcher
from labrun.engine.simulation import server as simulated_server
from labrun.engine.simulation.history import History
from labrun.engine.simulation.protocols import ACTIONS

STEPS = [
    {"do": "b.set", "with": {"n": 1, "to": 1}},
    {"id": "pause", "do": "a.look"},
    {"wait": "1 s"},
    {"id": "shot", "do": "a.fire"},
]


class Lived(History):
    """Servers are killed as soon as b is set."""

    struck, once = "b", True

    def _heard(self, event):
        super()._heard(event)
        about = (event.event, event.path, event.state)
        if self.once and about == ("goal", "main/pause", "succeeded"):
            self.once = False
            for server in self.servers:
                if server.instrument.name in self.struck:
                    server.kill()


def live(folder, monkeypatch, *, away_s, concurrent=False, steps=STEPS, start_timeout="5 s"):
    monkeypatch.setattr(simulated_server, "DOWN_S", (away_s, away_s))
    for name in "ab":
        told = {
            "type": f"{name}@1", "safe_state": ["rest"], "actions": ACTIONS,
            "concurrent": concurrent,
        }  # fmt: skip
        (folder / f"{name}.json").write_text(json.dumps(told))
    devices = {n: {"contract": f"{n}@1", "url": f"http://{n}"} for n in "ab"}
    lab = {
        "name": "l", "simulated": True, "start_timeout": start_timeout,
        "contracts": ["./a.json", "./b.json"], "devices": devices,
    }  # fmt: skip
    (folder / "lab.json").write_text(json.dumps(lab))
    protocol = {"labrun": 1, "name": "p", "devices": {n: f"{n}@1" for n in "ab"}, "steps": steps}
    (folder / "p.json").write_text(json.dumps(protocol))
    checked = check_file(folder / "p.json", lab=folder / "lab.json")
    assert checked.ok, checked.problems
    lived = Lived(checked, 1, accidents=0, ledgers=False)
    return lived.live(), lived.bench.deeds


def told(outcome, words):
    return [line for line in outcome.story if words in line]


@pytest.mark.parametrize("concurrent", [False, True])
@pytest.mark.parametrize(("away_s", "least_s", "most_s"), [(30, 5, 6.5), (3, 3, 5)])
def test_a_shot_waits_until_the_other_is_back_or_for_as_long_as_the_lab_says(
    tmp_path, monkeypatch, concurrent, away_s, least_s, most_s
):
    outcome, deeds = live(tmp_path, monkeypatch, away_s=away_s, concurrent=concurrent)
    (out,) = told(outcome, "is out of reach")
    since = float(out.split()[0])

    assert outcome.breaches == []
    assert "for 5 s (`start_timeout`) at most" in out
    assert [d.goal.split("/")[2] for d in deeds] == ["shot"]
    assert least_s <= deeds[0].at_s - since <= most_s + 2.1  # a shot takes up to 2 s
    assert len(told(outcome, "b is not back after 5 s")) == (away_s > 5)


def test_shots_side_by_side_on_devices_that_are_both_away_wait_for_one_another_and_end(
    tmp_path, monkeypatch
):
    members = [{"id": f"{d}{n}", "do": f"{d}.fire"} for d in "ab" for n in range(3)]
    steps = [{"do": "a.set", "with": {"n": 1, "to": 1}}, *STEPS[:3], {"parallel": members}]
    monkeypatch.setattr(Lived, "struck", "ab")
    outcome, deeds = live(tmp_path, monkeypatch, away_s=30, concurrent=True, steps=steps)

    assert outcome.breaches == []
    assert len(deeds) == 6


def test_a_run_that_waits_for_it_says_for_whom_and_until_when(tmp_path, monkeypatch):
    monkeypatch.setattr("labrun.engine.tree.tick.QUIET_S", 2.0)
    monkeypatch.setattr(Dispatcher, "longest_s", lambda dispatcher: 0.0)
    outcome, _ = live(tmp_path, monkeypatch, away_s=30)

    (line, *_) = told(outcome, "still waiting for")
    assert "still waiting for a, which waits for b until " in line
    assert line.endswith(" at most, to begin a.fire")
