"""A device server that is killed, a run that is cancelled, an end in order."""

import asyncio
import json
import os
import signal
from dataclasses import replace

import pytest

from labrun.engine.lab.lab import load_lab
from labrun.engine.run.virtual_time import VirtualLoop
from labrun.web.ros.offers.device import Device

from .served import command, serve
from .test_frames import GLOW, talking


@pytest.fixture(scope="module")
def own(lab, tmp_path_factory):
    """An endpoint that the tests here may hurt; the last of them ends it."""
    served = serve(tmp_path_factory.mktemp("own"), lab=lab)
    yield served

    assert served.process.poll() is not None or served.end() == 0
    assert "Traceback" not in (served.folder / "ros.log").read_text()


def server_pid(served, device):
    return json.loads((served.folder / ".labrun/ros/servers" / device / "server.json").read_text())[
        "pid"
    ]


@pytest.mark.slow
def test_a_goal_is_aborted_at_once_when_its_device_server_is_killed_and_the_next_works(own):
    async def main():
        async with talking(own.url) as talk:
            await talk.say({**GLOW, "id": "g", "args": {"seconds": 60}, "feedback": True})
            await talk.hear("action_feedback")
            os.kill(server_pid(own, "Lamp__9_"), signal.SIGKILL)
            async with asyncio.timeout(50):  # the goal itself would take a minute
                told = await talk.hear("action_result")
            while True:
                await talk.say({**GLOW, "id": "again", "args": {"seconds": 0.0}})
                again = await talk.hear("action_result")
                if again["result"]:
                    return told, again
                await asyncio.sleep(0.2)

    told, again = asyncio.run(main())

    assert told["status"] == 6 and told["values"]["error_name"] == "Lost"
    assert told["values"]["error_happened"] == "unknown"
    assert again["status"] == 4


@pytest.mark.parametrize(
    ("links", "lost"),
    [
        ([(0, False), (59, True), (1, False), (59, True)], False),  # slow, but it returns
        ([(0, False), (61, None)], True),
        ([(0, False), (61, True)], False),
    ],
)
def test_a_server_out_of_reach_keeps_its_goals_for_the_labs_start_timeout(
    lab, tmp_path, links, lost
):
    """`links`: after how many seconds the connection broke (False) or was there again (True)."""
    loaded, _ = load_lab(lab)
    loaded = replace(loaded, lab=loaded.lab.model_copy(update={"start_timeout": "60 s"}))

    async def story():
        device = Device("slow", loaded, tmp_path, "ros-1", lambda status: None)
        for after_s, up in links:
            await asyncio.sleep(after_s)
            if up is not None:
                device._on_link(up)
        try:
            return device.lost.is_set()
        finally:
            await device.close()

    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        assert runner.run(story()) is lost


@pytest.mark.slow
def test_cancelling_run_protocol_aborts_the_run(own):
    (own.folder / "long.yaml").write_text(
        "labrun: 1\nname: long\ndevices: {slow: gantry@1}\nsteps:\n"
        "  - foreach: {i: '${{ range(500) }}'}\n    steps:\n"
        "      - {do: slow.move_to, with: {x: '${{ i }}'}}\n      - wait: 200 ms\n"
    )
    run = {"op": "send_action_goal", "action": "/labrun/run_protocol", "id": "r", "feedback": True}
    told = []

    async def main():
        async with talking(own.url) as talk:
            bind = json.dumps({"slow": "slow"})
            await talk.say({**run, "args": {"protocol": "long.yaml", "bind_json": bind}})
            while True:
                message = await talk.hear()
                told.append(message)
                if message["op"] == "action_result":
                    return message
                if message["values"]["done"] == 2:
                    await talk.say({"op": "cancel_action_goal", "action": run["action"], "id": "r"})

    end = asyncio.run(main())

    assert end["status"] == 5 and end["values"]["fate"] == "aborted", end
    assert told[0]["values"]["run"] == end["values"]["run"]
    progress = [m["values"]["progress"] for m in told[:-1] if m["values"]["total"]]
    assert progress == sorted(progress) and 0 < progress[-1] < 0.2
    assert (own.folder / "runs" / end["values"]["run"] / "journal.jsonl").is_file()


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ({"protocol": "nothing.yaml"}, "there is no protocol 'nothing.yaml'"),
        ({"protocol": "../../etc/passwd"}, "not a file name inside"),
        ({"protocol": "/etc/passwd"}, "not a file name inside"),
        ({"protocol": "link.yaml"}, "there is no protocol"),
        ({"protocol": ""}, "not a file name inside"),
        (
            {"protocol": "hello", "params_json": '{"there": "4 s"}'},
            "Nothing was sent to any device",
        ),
        ({"protocol": "hello", "params_json": "[1]"}, "must be a JSON object"),
        ({"protocol": "hello", "params_json": "{"}, "is not JSON"),
        ({"protocol": "hello", "bind_json": '{"gantry": "nobody"}'}, "nobody"),
        ({"protocol": 3}, "must be a string"),
    ],
)
def test_a_protocol_that_cannot_run_is_refused_with_the_checkers_words(
    endpoint, tmp_path_factory, args, words
):
    outside = tmp_path_factory.mktemp("outside") / "other.yaml"
    outside.write_text("labrun: 1\nname: other\nsteps: [{log: hello}]\n")
    link = endpoint.folder / "link.yaml"
    if not link.is_symlink():
        link.symlink_to(outside)

    async def main():
        async with talking(endpoint.url) as talk:
            await talk.say(
                {
                    "op": "send_action_goal",
                    "action": "/labrun/run_protocol",
                    "id": "r",
                    "args": args,
                }
            )
            return await talk.hear()

    told = asyncio.run(main())

    assert told["result"] is False and words in told["values"]


def test_who_starts_it_is_told_what_is_armed_by_that(endpoint):
    assert (
        "armed for every client, without further confirmation: gantry (motion), slow (motion)"
        in (endpoint.said)
    )
    assert "actions; Ctrl-C ends it and leaves the devices safe" in endpoint.said


def test_a_second_one_from_the_same_folder_is_told_so(endpoint, lab):
    done = command(endpoint.folder, "--lab", str(lab), "--port", "0")

    assert done.returncode == 2
    assert "another `labrun ros` uses it" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.slow
def test_ctrl_c_ends_goals_and_devices_in_order(own):
    async def main():
        async with talking(own.url) as talk:
            await talk.say({**GLOW, "id": "g", "args": {"seconds": 60}, "feedback": True})
            await talk.hear("action_feedback")

    asyncio.run(main())
    pid = server_pid(own, "Lamp__9_")

    assert own.end() == 0
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
