"""Devices by hand: forms, actions, arming, jogging, and the stop."""

import json
import os
import signal
import time

import pytest

from labrun.schemas.contracts import shipped_contracts

pytestmark = pytest.mark.slow

STAGE = """\
name: small
simulated: true
contracts: [./stage.yaml]
devices:
  gantry:
    contract: stage@1
    driver: "./stage.py:Stage"
    config: {{clock: {clock}, homed: true}}
"""
STAGE_DRIVER = """\
from labrun.drivers.simulated.gantry import SimGantry


class Stage(SimGantry):
    contract = "stage@1"
"""


def test_a_device_tells_its_state_and_its_actions_as_forms(shared, page):
    page.reach("gantry", "libs")
    states = {state["name"]: state for state in page.get("/devices").json()}
    gantry = page.get("/devices/gantry").json()
    move = next(form for form in gantry["actions"] if form["name"] == "move_to")
    libs = page.get("/devices/libs").json()

    assert list(states) == ["gantry", "libs"]
    assert states["gantry"]["word"] == "idle" and states["gantry"]["status_at"]
    assert gantry["axes"] == ["x", "y", "z"] and gantry["ranges_mm"]["y"] == [0, 400]
    assert move["params"]["properties"]["y"]["maximum"] == 400  # this bench's, not the contract's
    assert move["params"]["properties"]["x"]["unit"] == "mm"
    assert {form["name"]: form["level"] for form in libs["actions"]} == {
        "measure": 3, "last_shot": 0, "export": 1, "disarm": 1, "locate": 0, "reconnect": 1,
    }  # fmt: skip
    assert page.get("/devices/none").status_code == 404


def test_an_action_by_hand_is_done_and_told_as_a_step(shared, page):
    page.reach("gantry")
    done = page.command("/devices/gantry/actions/move_to", {"params": {"x": "2 cm", "z": 5}})
    goal = done.json()

    assert done.status_code == 202
    assert goal["state"] == "SUCCEEDED"
    assert (goal["result"]["x"], goal["result"]["z"]) == pytest.approx((20, 5), abs=0.01)
    assert goal["step"] == "{do: gantry.move_to, with: {x: 20, z: 5}}" and goal["by"] == "Ada"
    assert page.get(f"/goals/{goal['id']}").json() == goal


def test_parameters_that_do_not_fit_are_refused_each_with_its_words(shared, page):
    page.reach("gantry")
    beyond = page.command("/devices/gantry/actions/move_to", {"params": {"y": 500}})
    unit = page.command("/devices/gantry/actions/move_to", {"params": {"x": "4 s"}})
    unknown = page.command("/devices/gantry/actions/jump", {})

    assert beyond.status_code == 422 and "400" in beyond.json()["details"]["params"]["y"]
    assert unit.status_code == 422 and "time" in unit.json()["details"]["params"]["x"]
    assert unknown.status_code == 404


def test_a_hazard_is_armed_held_and_done_once(shared, page):
    page.reach("libs")
    unarmed = page.command("/devices/libs/actions/measure", {})
    armed = page.command("/devices/libs/arm", {"action": "measure"}).json()
    state = page.get("/devices/libs").json()
    other = shared.client()
    taken = other.take("Bo", reason="my turn")
    time.sleep(armed["hold_s"])
    page.command("/devices/gantry/actions/move_to", {"params": {"x": 1, "y": 1, "z": 0}})
    shots = len(shared.truth("libs"))
    fired = page.command("/devices/libs/actions/measure", {"armed": armed["id"]})
    again = page.command("/devices/libs/actions/measure", {"armed": armed["id"]})

    assert (unarmed.status_code, unarmed.json()["code"]) == (409, "NOT_ARMED")
    assert state["armed"] == "Ada" and armed["danger"] == "laser"
    assert (taken.status_code, taken.json()["code"]) == (409, "ARMED")
    assert fired.json()["state"] == "SUCCEEDED"
    assert (again.status_code, again.json()["code"]) == (409, "NOT_ARMED")
    assert len(shared.truth("libs")) == shots + 1


def test_a_file_that_an_action_gives_can_be_fetched(shared, page):
    page.reach("gantry", "libs")
    page.command("/devices/gantry/actions/move_to", {"params": {"x": 2, "y": 2, "z": 0}})
    armed = page.command("/devices/libs/arm", {"action": "measure"}).json()
    time.sleep(armed["hold_s"])
    shot = page.command("/devices/libs/actions/measure", {"armed": armed["id"]}).json()
    asked = {"params": {"shot": shot["result"]["shot_id"], "file": "one.csv"}}
    goal = page.command("/devices/libs/actions/export", asked).json()
    outside = page.command(
        "/devices/libs/actions/export", {"params": {"shot": "x", "file": "../../etc/x"}}
    )
    file = page.get(f"/goals/{goal['id']}/files/one.csv")

    assert goal["files"] == ["one.csv"]
    assert file.text.startswith("wavelength,intensity")
    assert outside.status_code == 422
    assert page.get(f"/goals/{goal['id']}/files/..%2f..%2fcommands.sqlite").status_code == 404


def test_a_step_moves_from_where_the_device_stands_and_never_beyond_its_limits(shared, page):
    page.reach("gantry")
    page.command("/devices/gantry/actions/move_to", {"params": {"x": 10, "y": 10}})
    steps = [
        page.command("/devices/gantry/jog/step", {"axis": "x", "distance_mm": d}).json()
        for d in (1, 1, 0.1)
    ]
    beyond = page.command("/devices/gantry/jog/step", {"axis": "y", "distance_mm": -50})
    none = page.command("/devices/libs/jog/step", {"axis": "x", "distance_mm": 1})

    assert [step["result"]["x"] for step in steps] == pytest.approx([11, 12, 12.1], abs=0.01)
    assert (beyond.status_code, beyond.json()["code"]) == (422, "LIMIT")
    assert "-40.0" in beyond.json()["message"]
    assert (none.status_code, none.json()["code"]) == (422, "NO_AXIS")


def moves(house):
    return [entry for entry in house.truth("gantry") if entry["what"] == "move"]


def travelled(house, before):
    """How far x has moved since, in mm; nothing where a slow machine gave the hold no time."""
    return sum(move["end"][0] - move["start"][0] for move in moves(house)[before:])


def is_free(client):
    """Nothing holds the gantry: a step along another axis is taken."""
    step = {"axis": "y", "distance_mm": 1}
    return client.command("/devices/gantry/jog/step", step).status_code == 202


def test_a_move_by_hand_is_held_and_let_go_on_while_another_move_is_refused(hand, wait_for):
    page = hand
    aim = 200 if page.get("/devices/gantry").json()["status"]["x"] < 100 else 0
    moving = page.command("/devices/gantry/actions/move_to", {"params": {"x": aim}}).json()
    held = page.command("/devices/gantry/actions/hold", {}).json()
    wait_for(lambda: page.get("/devices/gantry").json()["status"]["state"] == "hold", "the hold")
    other = page.command("/devices/gantry/actions/move_to", {"params": {"x": 100}})
    page.command("/devices/gantry/actions/resume", {})
    wait_for(lambda: page.get(f"/goals/{moving['id']}").json()["ended_at"], "the end")

    assert moving["ended_at"] is None and held["state"] == "SUCCEEDED"
    assert (other.status_code, other.json()["code"]) == (409, "BUSY")
    assert page.get(f"/goals/{moving['id']}").json()["result"]["x"] == pytest.approx(aim, abs=0.01)


def test_a_hold_stops_by_itself_when_no_keep_alive_comes(unhurried, hand, wait_for):
    made, client, before = unhurried, hand, len(moves(unhurried))
    asked = {"axis": "x", "direction": 1, "feed_mm_min": 600}  # 10 mm/s, 20 mm a stretch
    jog = client.command("/devices/gantry/jog/start", asked).json()
    wait_for(lambda: is_free(client), "the rest")
    # A keep-alive does not revive what has been stopped.
    told = client.post(f"/jogs/{jog['id']}/beat").json()

    assert jog["moving"] and jog["dead_man_ms"] == 300
    assert told["moving"] is False and told["reason"] == "no keep-alive for 300 ms"
    assert travelled(made, before) < 19  # cut short: a stretch would be 20 mm


def test_a_hold_goes_on_while_keep_alives_come(unhurried, hand, socket, wait_for):
    before = len(moves(unhurried))

    def place():
        return hand.get("/devices/gantry").json()["status"]["y"]

    start = place()
    jog, stopped = held_until(lambda: place() > start + 21, unhurried, hand, socket)
    wait_for(lambda: moves(unhurried)[before:], "the move")
    (move,) = moves(unhurried)[before:]

    assert jog["moving"]
    assert stopped["moving"] is False and stopped["reason"] == "let go"
    assert move["end"][1] - move["start"][1] > 20  # a stretch would be 20 mm


def test_where_a_device_has_no_jog_a_hold_goes_on_over_stretches(house, socket, wait_for):
    contract = shipped_contracts()["gantry@1"].model_dump(mode="json") | {"type": "stage@1"}
    contract["actions"] = {name: contract["actions"][name] for name in ("home", "move_to", "halt")}
    beside = {"stage.yaml": json.dumps(contract), "stage.py": STAGE_DRIVER}
    made = house(clock=1, lab=STAGE, beside=beside)
    client = made.client()
    client.take()
    client.reach("gantry")
    jog, stopped = held_until(lambda: len(moves(made)) >= 2, made, client, socket)

    assert jog["moving"]
    assert stopped["moving"] is False and stopped["reason"] == "let go"
    assert abs(moves(made)[0]["end"][1] - 20) < 0.01  # the first stretch to its end


def held_until(far_enough, made, client, socket):
    """The y axis held by a person at 10 mm/s, then let go: however slow the machine is."""
    ui = socket(made, client)
    asked = {"axis": "y", "direction": 1, "feed_mm_min": 600, "dead_man_ms": 2000}
    jog = client.command("/devices/gantry/jog/start", asked).json()
    while not far_enough():
        ui.emit("jog", {"id": jog["id"]})
        time.sleep(0.1)
    return jog, client.post(f"/jogs/{jog['id']}/stop").json()


def test_a_hold_ends_with_the_connection_that_kept_it_alive(unhurried, hand, socket, wait_for):
    made, client, before = unhurried, hand, len(moves(unhurried))
    ui = socket(made, client)
    asked = {"axis": "x", "direction": 1, "feed_mm_min": 600}
    jog = client.command("/devices/gantry/jog/start", asked).json()
    ui.call(
        "snapshot"
    )  # the order on one socket is kept: the keep-alive arrived before this answer
    ui.emit("jog", {"id": jog["id"]})
    ui.call("snapshot")
    ui.close()
    wait_for(lambda: is_free(client), "the rest")

    assert jog["moving"]
    assert travelled(made, before) < 19


def test_a_hold_cannot_run_beyond_the_end_of_its_axis(shared, page, wait_for):
    page.reach("gantry")
    page.command("/devices/gantry/actions/move_to", {"params": {"x": 0}})
    asked = {"axis": "x", "direction": -1, "feed_mm_min": 600}
    jog = page.command("/devices/gantry/jog/start", asked).json()
    reason = wait_for(lambda: page.post(f"/jogs/{jog['id']}/beat").json()["reason"], "its end")

    assert reason == "x is at its limit"
    wait_for(lambda: page.get("/devices/gantry").json()["status"]["x"] == 0, "its last status")


def test_stop_all_needs_no_sign_in_and_breaks_off_what_moves(unhurried, hand, wait_for):
    made, client, before = unhurried, hand.reach("libs"), len(moves(unhurried))
    asked = {"params": {"x": 700, "feed": 1000}}
    goal = client.command("/devices/gantry/actions/move_to", asked).json()
    nobody = type(client)(made.url)
    stopped = nobody.post("/stop").json()
    nobody.close()
    wait_for(lambda: client.get(f"/goals/{goal['id']}").json()["ended_at"], "the end")
    over = client.get(f"/goals/{goal['id']}").json()
    after = client.command("/devices/gantry/jog/step", {"axis": "x", "distance_mm": 1})

    assert goal["state"] == "EXECUTING" and goal["ended_at"] is None
    assert stopped["all_confirmed"] and {d["device"] for d in stopped["devices"]} == {
        "gantry",
        "libs",
    }
    assert over["state"] in ("CANCELED", "ABORTED")
    assert moves(made)[before]["end"][0] < 699
    assert after.status_code == 202  # a person who acts again has decided to


@pytest.mark.posix("Windows has no such signal")
def test_stop_all_says_which_device_did_not_confirm(shared, page, socket):
    made, client = shared, page.reach("gantry", "libs")
    ui = socket(made, client)
    pid = made.server_pid("libs")
    os.kill(pid, signal.SIGSTOP)
    try:
        began = time.monotonic()
        stopped = client.post("/stop").json()
        took = time.monotonic() - began
        by_socket = ui.call("stop")
    finally:
        os.kill(pid, signal.SIGCONT)
    told = {one["device"]: one["confirmed"] for one in stopped["devices"]}

    assert told == {"gantry": True, "libs": False} and not stopped["all_confirmed"]
    assert took < 5  # not the ten seconds that a device server may take
    assert not by_socket["all_confirmed"]
    assert any("libs did not confirm" in notice["text"] for notice in ui.all("notice"))


def test_a_device_server_that_dies_is_told_as_lost_and_started_again(
    shared, page, socket, wait_for
):
    made, client = shared, page.reach("gantry")
    ui = socket(made, client)
    os.kill(made.server_pid("gantry"), signal.SIGKILL)

    def reaches():
        return [
            patch["devices"]["gantry"]["reach"]
            for patch in ui.all("patch")
            if patch["devices"].get("gantry")
        ]

    wait_for(lambda: "lost" in reaches(), "lost")
    client.reach("gantry")

    assert client.get("/devices/gantry").json()["reason"] == ""


def test_a_device_of_a_run_is_not_for_hands(unhurried, hand, wait_for):
    made, client = unhurried, hand
    id = client.run_of("long.yaml", checklist=[])
    wait_for(lambda: client.run(id)["live"], "live")
    refused = client.command("/devices/gantry/actions/move_to", {"params": {"x": 1}})
    jog = client.command(
        "/devices/gantry/jog/start", {"axis": "x", "direction": 1, "feed_mm_min": 60}
    )
    second = client.command("/runs", {"protocol": "talk.yaml"})
    stopped = client.post("/stop").json()
    client.until(id, "aborted")
    count = len(moves(made))

    assert client.get("/devices/gantry").json()["used_by"] in (id, None)
    for answer in (refused, jog, second):
        assert (answer.status_code, answer.json()["code"]) == (409, "HELD")
        assert answer.json()["details"]["run"] == id
    assert stopped["runs"] == [{"run": id, "told": True, "message": stopped["runs"][0]["message"]}]
    assert len(moves(made)) == count
