"""Jogging a device that jogs by itself: its own dead-man, fed with what the browser says."""

import importlib.util
import time
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from labrun.schemas.contract import Contract
from labrun.schemas.contracts import shipped_contracts
from labrun.schemas.lab import Limit
from labrun.web.devices.form import moving_of
from labrun.web.devices.held import jogging_of

pytestmark = pytest.mark.slow


PEER = importlib.util.spec_from_file_location("jog_peer", Path(__file__).with_name("jog_peer.py"))
jog_peer = importlib.util.module_from_spec(PEER)
PEER.loader.exec_module(jog_peer)

LAB = """\
name: elsewhere
contracts: [./stage.yaml]
devices:
  stage: {{contract: stage@1, url: "{url}", limits: {{y: {{minimum: 0, maximum: 60}}}}}}
"""
HOLD = {"axis": "x", "direction": 1, "feed_mm_min": 600}


@pytest.fixture(scope="module")
def lasting_stage():
    made = jog_peer.Stage()
    made.url = made.open()
    yield made
    made.close()


@pytest.fixture(scope="module")
def served(lasting, lasting_stage, tmp_path_factory):
    """A server whose lab has the stage."""
    folder = tmp_path_factory.mktemp("lab")
    with (folder / "stage.yaml").open("w") as file:
        YAML(typ="safe", pure=True).dump(jog_peer.CONTRACT, file)
    (folder / "lab.yaml").write_text(LAB.format(url=lasting_stage.url))
    return lasting(arguments=["--lab", str(folder / "lab.yaml")])


@pytest.fixture
def stage(lasting_stage, wait_for):
    """The stage, at rest in the middle, with no memory of what it did before."""
    wait_for(lambda: not lasting_stage.running, "rest")
    lasting_stage.begin()
    return lasting_stage


@pytest.fixture
def hand(served, stage, wait_for):
    """The server, started again where a test killed it, and a browser with control of it."""
    if served.process.poll() is not None:
        served.start()
    client = served.client()
    client.take("Ada", reason="a test begins")
    client.reach("stage")

    def is_told():
        told = client.get("/devices/stage").json()["status"]
        return told["homed"] and all(told[axis] == stage.place[axis] for axis in "xyz")

    wait_for(is_told, "the stage as it is")
    return served, client


def say(client, jog, seconds):
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        told = client.post(f"/jogs/{jog['id']}/beat").json()
        if not told["moving"]:
            return told
        time.sleep(0.05)
    return told


def held_for(client, stage, seconds):
    """A hold that is under way; on a machine where even this test comes too late, another one."""
    while True:
        stage.goals.clear()
        stage.sent_again = 0
        jog = client.command("/devices/stage/jog/start", HOLD).json()
        if "id" not in jog:  # the one before has yet to end
            assert jog["code"] == "BUSY"
            time.sleep(0.1)
            continue
        told = say(client, jog, seconds)
        if told["moving"] and stage.running:
            return jog, told


def test_a_hold_is_one_goal_that_goes_on_while_the_browser_says_so(hand, stage):
    _, client = hand
    jog, told = held_for(client, stage, 1)
    stopped = client.post(f"/jogs/{jog['id']}/stop").json()
    place = stage.place["x"]
    time.sleep(0.3)

    assert told["moving"] and (stopped["moving"], stopped["reason"]) == (False, "let go")
    ((action, params),) = stage.goals
    assert action == "jog"
    assert params == {"axis": "x", "direction": "+", "feed": 600, "lease": 0.3}
    assert stage.sent_again >= 2
    assert place > 50 and stage.place["x"] == place


def test_a_silent_browser_is_nobody_and_the_server_does_not_speak_for_it(hand, stage, wait_for):
    _, client = hand
    jog = client.command("/devices/stage/jog/start", HOLD).json()
    wait_for(lambda: stage.ended, "the end of the jog")
    time.sleep(1)  # until the server has heard of it, too; asking would be a keep-alive
    told = client.post(f"/jogs/{jog['id']}/beat").json()

    assert told["moving"] is False and "no keep-alive" in told["reason"]
    assert stage.sent_again == 0
    assert stage.place["x"] < 60


def test_the_device_stops_by_itself_when_the_server_is_killed(hand, stage, wait_for):
    made, client = hand
    held_for(client, stage, 0.3)
    (running,) = stage.running
    made.kill()
    wait_for(lambda: not stage.running, "rest")

    assert stage.ended[running]["state"] == "SUCCEEDED"  # its lease lapsed: nobody asked


def test_a_device_that_hears_no_keep_alive_stops_and_that_is_told(hand, stage):
    _, client = hand
    stage.deaf = True
    jog = client.command("/devices/stage/jog/start", HOLD).json()
    told = say(client, jog, 5)

    assert told["moving"] is False
    assert stage.place["x"] < 60


def test_a_hold_ends_at_the_end_of_the_axis(hand, stage):
    _, client = hand
    stage.place["z"] = 1.0
    jog = client.command("/devices/stage/jog/start", HOLD | {"axis": "z", "direction": -1}).json()
    told = say(client, jog, 5)

    assert (told["moving"], told["reason"]) == (False, "z is at its limit")
    assert stage.place["z"] == 0


def test_a_step_is_a_distance_that_the_device_adds_to_its_own_place(hand, stage, wait_for):
    _, client = hand
    step = client.command("/devices/stage/jog/step", {"axis": "y", "distance_mm": 1.5}).json()
    beyond = client.command("/devices/stage/jog/step", {"axis": "y", "distance_mm": 20})
    fast = client.command("/devices/stage/jog/start", HOLD | {"feed_mm_min": 9000})
    stage.homed = False
    wait_for(lambda: client.get("/devices/stage").json()["status"]["homed"] is False, "no home")
    creep = client.command("/devices/stage/jog/step", {"axis": "z", "distance_mm": -2})

    assert step["state"] == "SUCCEEDED" and step["step"].startswith("{do: stage.jog")
    assert stage.goals[0] == ("jog", {"axis": "y", "distance": 1.5})
    assert (beyond.status_code, beyond.json()["code"]) == (422, "LIMIT")
    assert (fast.status_code, fast.json()["code"]) == (422, "PARAMS")
    assert creep.json()["state"] == "SUCCEEDED" and stage.place["z"] == 48


def test_axes_go_along_with_the_first_in_a_step_and_in_a_hold(hand, stage):
    _, client = hand
    path, along = "/devices/stage/jog/step", {"y": -1}
    step = client.command(path, {"axis": "x", "distance_mm": -1.5, "along": along}).json()
    beyond = client.command(path, {"axis": "x", "distance_mm": 12, "along": {"y": 1}})
    twice = client.command(path, {"axis": "x", "distance_mm": 1, "along": {"x": -1}})
    jog = client.command("/devices/stage/jog/start", HOLD | {"along": along}).json()
    stopped = client.post(f"/jogs/{jog['id']}/stop").json()

    assert step["state"] == "SUCCEEDED" and stopped["moving"] is False
    assert stage.goals[0] == ("jog", {"way": "-x-y", "distance": 1.5})
    assert stage.goals[1][1] == {"way": "+x-y", "feed": 600, "lease": 0.3}
    assert (beyond.status_code, beyond.json()["code"]) == (422, "LIMIT")
    assert (twice.status_code, twice.json()["code"]) == (422, "ONE_AXIS")


def test_a_gantry_whose_ends_only_it_knows_can_be_jogged_all_the_same():
    gantry = shipped_contracts()["gantry@2"]
    ends = {"x": Limit(minimum="0 mm", maximum="40 cm")}

    assert moving_of(gantry, {}).axes == ("x", "y", "z") and moving_of(gantry, {}).ranges_mm == {}
    assert moving_of(gantry, ends).ranges_mm == {"x": (0, 400)}


def test_only_what_both_sides_know_as_a_jog_is_one():
    contract = Contract.model_validate(jog_peer.CONTRACT)
    other = {**jog_peer.CONTRACT, "actions": {"move_to": {}}}
    endless = jog_peer.CONTRACT["actions"]["jog"] | {"cancel": False}
    actions = jog_peer.CONTRACT["actions"] | {"jog": endless}

    assert jogging_of(contract, jog_peer.CONTRACT).most_feed == 2500
    assert jogging_of(contract, other) is None
    assert jogging_of(contract.model_copy(update={"actions": {}}), jog_peer.CONTRACT) is None
    assert (
        jogging_of(
            Contract.model_validate(jog_peer.CONTRACT | {"actions": actions}), jog_peer.CONTRACT
        )
        is None
    )
