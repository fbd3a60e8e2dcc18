"""What becomes of an action whose outcome, file or intent is damaged, late, or never leaves."""

import errno
import os
import re
from hashlib import sha256

import pytest

from labrun.drivers.client.client import DeviceClient
from labrun.drivers.server.execution import Execution
from labrun.drivers.server.ledger import Ledger, LedgerFault
from labrun.engine.dispatch.dispatcher import Dispatcher
from labrun.engine.runner import session
from labrun.engine.tree.nodes import unknown

CAMERA = """
from labrun.drivers.driver import Driver
from labrun.schemas.messages import FileContent


class Camera(Driver):
    contract = "camera@1"

    async def shoot(self, goal, *, file):
        with (self.place.world / "calls.jsonl").open("a") as log:
            log.write('{"run": "%s", "name": "shot", "word": "ok"}\\n' % goal.id.partition("/")[0])
        goal.files["file"] = FileContent(path=file, sha256="DIGEST", data=b"light")
        return {"file": file}
"""
A_FILE = {
    "type": "object",
    "required": ["file"],
    "properties": {"file": {"type": "string", "format": "path"}},
}
SHOOT = {"effect": "once", "duration": "1 s", "params": A_FILE, "returns": A_FILE}


def camera(own_device, folder, digest):
    (folder / "camera.py").write_text(CAMERA.replace("DIGEST", digest))
    changes = {"type": "camera@1", "safe_state": [], "actions": {"shoot": SHOOT}}
    return own_device(folder / "camera.py:Camera", **changes)


PICTURE = "steps: [{id: shot, do: a.shoot, with: {file: p.raw}, retry: 3}]\n"


def test_a_file_that_comes_with_a_shot_is_in_the_runs_folder(own_device, tmp_path):
    ran = camera(own_device, tmp_path, sha256(b"light").hexdigest()).run(PICTURE)

    assert (ran.status, ran.sent()) == (0, ["shot"])
    assert (ran.folder / "p.raw").read_bytes() == b"light"


def test_a_shot_whose_file_is_damaged_was_fired_and_is_not_fired_again(own_device, tmp_path):
    device = camera(own_device, tmp_path, "0" * 64)
    ran = device.run(PICTURE)
    resumed = device.resume()

    (ended,) = [r for r in ran.records if r.kind == "ended"]
    assert (ended.error.name, ended.error.happened) == ("Fault", "yes")
    assert "damaged" in ended.error.message
    assert (ran.status, resumed.status, resumed.sent()) == (1, 1, ["shot"])
    assert not (ran.folder / "p.raw").exists()


def test_a_goal_that_the_full_disk_kept_from_being_sent_is_sent_after_a_resume(
    own_device, monkeypatch
):
    device = own_device()
    write = os.write

    def full(file, data):
        if b'main/shot/1"' in bytes(data):
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(file, data)

    with monkeypatch.context() as disk:
        disk.setattr(os, "write", full)
        ran = device.run("""
steps:
  - {do: a.act, with: {name: lower}}
  - {id: shot, do: a.shoot, with: {name: shot}}
""")
        assert (ran.status, ran.sent()) == (1, ["lower"])
        assert not [r for r in ran.records if "main/shot" in r.model_dump_json()]

    resumed = device.resume()

    assert (resumed.status, resumed.sent()[-1]) == (0, "shot")
    assert [(r.id.partition("/")[2], r.state) for r in resumed.records if r.kind == "ended"][
        -1
    ] == (
        "main/shot/1",
        "SUCCEEDED",
    )


def test_a_probe_goes_before_what_waits_for_the_same_device(own_device):
    ran = own_device().run(
        """
steps:
  - {id: shot, do: a.shoot, with: {name: shot, script: "happened!,ok"}, mode: background}
  - {do: a.shoot, with: {name: next}, mode: background}
  - {do: a.shoot, with: {name: last}}
""",
        answers={"shot": "stop"},
    )

    assert ran.status == 0
    assert [r.action for r in ran.records if r.kind == "goal"] == [
        "shoot",
        "last",
        "shoot",
        "shoot",
    ]
    assert not [r for r in ran.records if r.kind == "asked"]


@pytest.mark.parametrize(("room_after", "asked"), [(2, []), (10**6, ["shot"])])
def test_a_probe_that_a_full_disk_refuses_is_asked_again_for_a_while(
    own_device, monkeypatch, room_after, asked
):
    refused = []
    admit = Ledger.admit

    def admit_with_room(ledger, goal, state):
        if "/probe/" in goal.id and len(refused) < room_after:
            refused.append(goal.id)
            raise LedgerFault("the ledger cannot be written: database or disk is full")
        return admit(ledger, goal, state)

    monkeypatch.setattr(Ledger, "admit", admit_with_room)
    monkeypatch.setattr(unknown, "PROBE_AGAIN_S", 0.05)
    device = own_device()
    if asked:  # no room will come
        monkeypatch.setattr(
            session, "Dispatcher", lambda run, clients, _: Dispatcher(run, clients, 0.2)
        )
    ran = device.run(
        'steps: [{id: shot, do: a.shoot, with: {name: shot, script: "happened!,ok"}}]',
        answers={"shot": "stop"},
    )

    questions = [r for r in ran.records if r.kind == "asked"]
    assert ran.status == (1 if asked else 0) and ran.sent()[0] == "shot"
    assert [r.id for r in questions] == asked and len(refused) >= 2
    assert all(
        "was refused: the ledger cannot be written: database or" in q.text for q in questions
    )


def test_what_waits_for_one_device_is_done_in_the_order_in_which_it_was_requested(own_device):
    steps = [f"  - {{do: a.act, with: {{name: n{i}}}, mode: background}}" for i in range(20)]
    ran = own_device().run("\n".join(["steps:", *steps]) + "\n")

    assert ran.status == 0
    assert ran.sent() == [f"n{i}" for i in range(20)]


PULSE = "steps: [{id: x, do: a.pulse, with: {name: x, seconds: 0.2}}]\n"


@pytest.fixture
def impatient(monkeypatch):
    """A client that soon gives up a server that it does not reach."""
    monkeypatch.setitem(DeviceClient.__init__.__kwdefaults__, "lost_after_s", 0.3)


def out_of_reach_at(device, moment):
    """A watcher that cuts the wire at an event, until the goal counts as lost."""
    left = [moment]

    def watch(event):
        if [f"{event.event} {event.state}".strip()] == left:
            left.clear()
            device.break_wire()
        elif (event.event, event.state) == ("goal", "lost"):
            device.mend_wire()

    return watch


def test_a_goal_out_of_reach_stays_open_and_its_outcome_is_fetched_on_resume(own_device, impatient):
    device = own_device()
    watch = out_of_reach_at(device, "feedback EXECUTING")
    ran = device.run(PULSE, answers={"x": "stop"}, watch=watch)
    before = [r for r in ran.records if r.kind == "ended"]
    resumed = device.resume(answers={"x": "repeat"})

    assert (ran.status, before) == (1, [])
    assert (resumed.status, resumed.sent()) == (0, ["x"])


def test_a_goal_in_flight_that_is_out_of_reach_on_resume_is_asked_about_again(
    own_device, impatient
):
    device = own_device()
    device.run(PULSE)
    device.kill_after('main/x/1"')
    ran = device.resume(answers={"x": "repeat"}, watch=out_of_reach_at(device, "goal sent"))

    assert (ran.status, ran.sent()) == (0, ["x"])
    assert not [r for r in ran.records if r.kind == "asked"]


def test_an_action_that_loses_a_race_is_cancelled_at_its_device(own_device):
    device = own_device()

    def watch(event):
        if event.event == "feedback":
            device.answer("enough", "yes")

    ran = device.run(
        """
steps:
  - any:
      - steps: [{do: a.act, with: {name: slow, script: hang}}]
      - steps: [{id: enough, confirm: Enough?}]
""",
        watch=watch,
    )

    assert ran.status == 0
    assert [r.state for r in ran.records if r.kind == "ended"] == ["CANCELED"]


def test_an_action_that_takes_too_long_is_cancelled_at_its_device_and_fails(own_device):
    ran = own_device().run(
        "steps: [{do: a.act, with: {name: slow, script: hang}, timeout: 0.2 s}]\n"
    )

    assert (ran.status, "Timeout: a.act took longer than 0.2 s" in ran.finished.detail) == (1, True)
    # whoever is first: the engine by its cancel, or the server by the goal's own deadline
    assert [r.state for r in ran.records if r.kind == "ended"] in (["CANCELED"], ["ABORTED"])


def test_what_took_too_long_stays_a_timeout_when_the_engine_is_killed_before_it_has_ended(
    own_device, monkeypatch
):
    # The engine's clock is first: the server only hears a cancel, and that is what its ledger says.
    monkeypatch.setattr(Execution, "_expire", lambda execution: None)
    device = own_device()
    protocol = """
steps:
  - do: a.act
    with: {name: slow, script: "hang,ok"}
    timeout: 0.2 s
    fallback: [{do: a.act, with: {name: "${{ error.name }}"}}]
"""
    device.run(protocol)
    device.kill_after('"kind":"expired"')

    ran = device.resume()

    assert [r.state for r in ran.records if r.kind == "ended"] == ["CANCELED", "SUCCEEDED"]
    # The fallback was sent under the same id before: its device does it only once.
    assert (ran.status, ran.sent()) == (0, ["slow", "Timeout"])


def test_a_run_that_waits_longer_than_it_knows_why_says_what_for_on_whom_and_since_when(
    own_device, monkeypatch
):
    monkeypatch.setattr("labrun.engine.tree.tick.QUIET_S", 0.05)
    monkeypatch.setattr(Dispatcher, "longest_s", lambda dispatcher: 0.0)
    said = []
    device = own_device()

    def watch(event):
        if event.event == "log":
            said.append(event.text)

    ran = device.run("steps: [{do: a.shoot, with: {name: x, seconds: 1}}]\n", watch=watch)

    assert ran.status == 0
    assert re.fullmatch(r"still waiting for a\.shoot on a, sent at \d\d:\d\d:\d\d", said[0]), said


def test_a_run_that_is_stopped_at_once_waits_for_nothing_and_still_ends_its_journal(own_device):
    device = own_device(safe_state=[], on_lease_lapse="finish")

    def watch(event):
        if (event.event, event.state) == ("feedback", "EXECUTING"):
            device.abort()
            device.abort()

    ran = device.run("steps: [{do: a.pulse, with: {name: x, script: hang}}]\n", watch=watch)

    assert (ran.status, ran.finished.kind, ran.finished.fate) == (1, "finished", "aborted")
    assert not [r for r in ran.records if r.kind == "ended"]
