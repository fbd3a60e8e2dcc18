"""Devices are brought to their safe state at the end of a run, goals in flight to their end at a resume."""

from pathlib import Path
from types import SimpleNamespace

import pytest
from py_trees.common import Status

from labrun.drivers.client.client import DeviceClient
from labrun.engine.dispatch.dispatcher import Dispatcher
from labrun.engine.dispatch.request import Request
from labrun.engine.journal.past import Past, PastGoal
from labrun.engine.runner.safe_state import InFlight, _probe_of
from labrun.schemas import journal as j
from labrun.schemas.contract import Action

SCRIPTED = f"{Path(__file__).parents[1] / 'scripted_lab' / 'scripted.py'}:Scripted"
STUCK = f"""
from pathlib import Path

from labrun.drivers.find import find_driver


class Stuck(find_driver("{SCRIPTED}", Path())):
    async def safe(self):
        raise RuntimeError("the brake is worn")
"""
ACT = "steps: [{do: a.act, with: {name: x}}]\n"


def watched(told):
    def watch(event):
        if event.event in ("safe", "log"):
            told.append((event.event, event.path, event.state))

    return watch


def test_a_device_that_is_safe_at_the_end_is_told_and_recorded_as_that(own_device):
    told = []
    ran = own_device().run(ACT, watch=watched(told))

    assert told == [("safe", "a", "confirmed")]
    assert [(r.device, r.confirmed) for r in ran.records if r.kind == "safe"] == [("a", True)]


def test_a_device_that_does_not_confirm_its_safe_state_is_told_and_recorded(own_device, tmp_path):
    (tmp_path / "stuck.py").write_text(STUCK)
    told = []
    ran = own_device(tmp_path / "stuck.py:Stuck").run(ACT, watch=watched(told))

    assert told == [("log", "", ""), ("safe", "a", "unconfirmed")]
    (safe,) = [r for r in ran.records if r.kind == "safe"]
    assert (safe.confirmed, "the brake is worn" in safe.message) == (False, True)


def test_a_device_without_a_safe_state_is_left_as_it_is(own_device):
    told = []
    ran = own_device(safe_state=[]).run(ACT, watch=watched(told))

    assert told == []
    assert not [r for r in ran.records if r.kind == "safe"]


PLAIN = """
from labrun.drivers.driver import Driver


class Plain(Driver):
    contract = "plain@1"

    async def touch(self, goal):
        return {}
"""


def test_a_device_without_a_safe_state_does_not_keep_the_others_from_theirs(own_device, tmp_path):
    (tmp_path / "plain.py").write_text(PLAIN)
    plain = {"type": "plain@1", "actions": {"touch": {"effect": "idempotent", "duration": "1 s"}}}
    told = []
    device = own_device(also={"Plain": (f"{tmp_path / 'plain.py'}:Plain", plain)})
    device.run("steps: [{do: Plain.touch}, {do: a.act, with: {name: x}}]\n", watch=watched(told))

    assert told == [("safe", "a", "confirmed")]


def test_a_device_that_was_not_used_is_left_as_it_is(own_device):
    told = []
    ran = own_device().run("steps: [{log: hello}]\n", watch=watched(told))

    assert [kind for kind, *_ in told] == ["log"]
    assert not [r for r in ran.records if r.kind == "safe"]


def test_a_goal_that_still_runs_at_a_resume_times_out_and_the_next_resume_tries_again(
    own_device, monkeypatch
):
    monkeypatch.setitem(DeviceClient.__init__.__kwdefaults__, "lost_after_s", 0.3)
    device = own_device(safe_state=[], on_lease_lapse="finish")
    step = "{id: x, do: a.act, with: {name: x, script: 'hang,ok'}, timeout: 3 s}"

    def watch(event):
        if event.event == "feedback":
            device.break_wire()
        elif (event.event, event.state) == ("goal", "lost"):
            device.mend_wire()

    told = []
    first = device.run(f"steps: [{step}]\n", watch=watch)
    second = device.resume(watch=lambda event: told.append((event.event, event.path, event.state)))
    why = second.finished.detail
    ran = device.resume()

    assert (first.status, second.status, ran.status) == (1, 1, 0)
    assert "took longer than 3 s" in why
    assert {path for kind, path, _ in told if kind == "goal"} == {"main/x"}
    assert ran.sent() == ["x", "x"]
    assert [r.state for r in ran.records if r.kind == "ended"] == ["ABORTED", "SUCCEEDED"]


@pytest.mark.parametrize("when", ["the resume begins", "it is asked about"])
def test_a_goal_that_still_runs_is_cancelled_when_the_resume_is_aborted(
    own_device, monkeypatch, when
):
    monkeypatch.setitem(DeviceClient.__init__.__kwdefaults__, "lost_after_s", 0.3)
    device = own_device(safe_state=[], on_lease_lapse="finish")
    told = []

    def lose(event):
        if event.event == "feedback":
            device.break_wire()
        elif (event.event, event.state) == ("goal", "lost"):
            device.mend_wire()

    def abort(event):
        told.append((event.event, event.state))
        begins = (event.event, event.state) == ("run", "running")
        if begins if when == "the resume begins" else told[-1] == ("goal", "sent"):
            device.abort()

    device.run("steps: [{do: a.act, with: {name: x, script: hang}, timeout: 300 s}]\n", watch=lose)
    ran = device.resume(watch=abort)

    assert ran.finished.fate == "aborted"
    assert [r.state for r in ran.records if r.kind == "ended"] == ["CANCELED"]
    assert ("goal", "canceled") in told


def test_a_server_that_says_nothing_of_a_device_has_not_confirmed_it(own_device, monkeypatch):
    async def silent(self, *devices, **more):
        return {}

    monkeypatch.setattr(DeviceClient, "stop", silent)

    ran = own_device().run("steps: [{do: a.act, with: {name: x}}]\n")

    assert [(r.confirmed, r.message) for r in ran.records if r.kind == "safe"] == [
        (False, "no answer")
    ]


def test_a_probe_that_an_abort_takes_back_before_it_is_sent_is_waited_for_no_more():
    run = SimpleNamespace(roles={}, history=SimpleNamespace(past=Past()))
    dispatcher = Dispatcher(run, {}, 60.0)
    action = Action(effect="pure")
    probe = Request("run/main/shot/1/probe/1", "main/shot/1/probe", None, "last", action, {}, 60.0)
    probe.role = SimpleNamespace(device="a", role="a")
    asked = InFlight(run, SimpleNamespace(aborted_by="Ctrl-C"), dispatcher, [probe])

    asked.tick_once()

    assert asked.status == Status.SUCCESS


@pytest.mark.parametrize("roles", [{}, {"c": "another"}, {"c": "a"}])
def test_what_a_changed_protocol_no_longer_has_is_not_probed(roles):
    sent = j.GoalSent(
        n=2, id="r/main/shoot/1", device="a", action="shoot", effect="once", boot="b", ledger="l",
        epoch=1, means="m",
    )  # fmt: skip
    contract = SimpleNamespace(actions={"act": Action()})
    made = {n: SimpleNamespace(device=device, contract=contract) for n, device in roles.items()}

    assert _probe_of(SimpleNamespace(roles=made), PastGoal(sent)) is None
