"""The device server in JavaScript of the docs keeps its contract, over the wire and over kills."""

import asyncio
import json
import random
import shutil
import socket
import subprocess
from collections import Counter
from pathlib import Path

import aiohttp
import pytest

from labrun.drivers.client.client import DeviceClient
from labrun.drivers.contract_tests import Case, ServerKeepsContract
from labrun.schemas.messages import Goal

from ..npm import installed
from .test_device_server import FRAMES

FOLDER = Path(__file__).parents[2] / "docs" / "how-to" / "device-server-in-javascript"
pytestmark = [pytest.mark.slow, pytest.mark.needs("node")]


@pytest.fixture(scope="class", autouse=True)
def server(request, tmp_path_factory):
    """The server's files beside what npm has for them: a script finds its modules there."""
    folder = tmp_path_factory.mktemp("javascript")
    for file in (*FOLDER.glob("*.mjs"), *FOLDER.glob("*.json")):
        shutil.copy(file, folder)
    (folder / "node_modules").symlink_to(installed(FOLDER, "socketio") / "node_modules")
    if request.cls is not None:
        request.cls.server = folder / "server.mjs"
    return folder / "server.mjs"


class TestPump(ServerKeepsContract):
    case = Case(
        contract=FOLDER / "pump.json",
        device="pump",
        good={"dose": {"volume": 3.0}, "last_dose": {}, "halt": {}},
        bad={"dose": [{"volume": "3 mL"}, {}], "halt": [{"hard": True}]},
        lasting="dose",
    )

    def command(self, folder, *, slow):
        return ["node", str(self.server), str(folder / "server"), "0", "pump"]

    def asked(self, folder):
        return [note["action"] for note in notes(folder)]

    def happened(self, folder, goal_id):
        return any(note["goal"] == goal_id for note in notes(folder))

    def is_safe(self, status):
        return status["flowing"] is False


class TestStage(ServerKeepsContract):
    """The one of a hundred lines, which has no ledger and needs none."""

    case = Case(
        contract=FOLDER / "stage.json",
        device="stage",
        good={"move_to": {"x": 60}, "halt": {}},
        bad={"move_to": [{"x": "3 mm"}, {}], "halt": [{"hard": True}]},
        lasting="move_to",
    )

    def command(self, folder, *, slow):
        return ["node", str(self.server.with_name("small-server.mjs")), "0"]

    def asked(self, folder):
        said = (folder / "server.log").read_text().splitlines()
        return [line.rpartition("stage.")[2] for line in said]

    def is_safe(self, status):
        return status["moving"] is False


def notes(folder):
    """What the pump itself remembers."""
    path = folder / "server" / "pump.jsonl"
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def test_a_second_server_on_the_same_port_does_not_touch_the_ledger(server, tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        command = ["node", str(server), str(tmp_path / "ledger"), str(taken.getsockname()[1])]
        ended = subprocess.run(command, capture_output=True, text=True, timeout=60)

    assert ended.returncode != 0 and "EADDRINUSE" in ended.stderr
    assert not (tmp_path / "ledger").exists()


def test_killed_again_and_again_it_does_no_dose_twice_and_every_verdict_is_true(server, tmp_path):
    chance, verdicts, done = random.Random(1), {}, asyncio.Event()
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]

    async def started():
        command = ["node", str(server), str(tmp_path / "server"), str(port)]
        process = await asyncio.create_subprocess_exec(*command, stdout=subprocess.PIPE)
        assert await process.stdout.readline()
        return process

    async def follow_doses(client):
        while not done.is_set():
            goal = Goal(
                id=f"run/{len(verdicts)}", device="pump", action="dose", boot=client.boot,
                epoch=client.epoch("pump"), params={"volume": 0.001, "rate": chance.choice([50, 0.1])},
            )  # fmt: skip
            verdicts[goal.id] = await client.follow(goal)

    async def story():
        process = await started()
        client = DeviceClient(f"http://127.0.0.1:{port}")
        await client.open()
        await client.take_lease("pump", "run")
        following = asyncio.create_task(follow_doses(client))
        for _ in range(4):
            await asyncio.sleep(chance.uniform(0.3, 0.6))
            process.kill()
            await process.wait()
            process = await started()
        async with asyncio.timeout(100):
            while sum(verdict.state == "SUCCEEDED" for verdict in verdicts.values()) < 20:  # noqa: ASYNC110
                await asyncio.sleep(0.02)
            done.set()
            await following
        await client.close()
        process.terminate()
        assert await process.wait() == 0

    asyncio.run(story())
    doses = Counter(note["goal"] for note in notes(tmp_path))
    happened = {i: v.error.happened if v.error else "yes" for i, v in verdicts.items()}

    assert max(doses.values()) == 1
    assert {i for i, word in happened.items() if word == "yes"} <= set(doses) <= set(verdicts)
    assert not {i for i, word in happened.items() if word == "no"} & set(doses)


def test_a_server_answers_the_frames_of_the_page_as_the_page_says(server, tmp_path):
    command = ["node", str(server), str(tmp_path / "server"), "0"]

    async def until(socket_io, wanted):
        """The rest of the first message that begins so; pings are answered."""
        while not (word := (await socket_io.receive(timeout=100)).data).startswith(wanted):
            if word == "2":
                await socket_io.send_str("3")
        return word.removeprefix(wanted)

    async def talk():
        process = await asyncio.create_subprocess_exec(*command, stdout=subprocess.PIPE)
        url = json.loads(await process.stdout.readline())["url"]
        heard, boot = {}, ""
        async with (
            aiohttp.ClientSession() as http,
            http.ws_connect(f"{url}/socket.io/?EIO=4&transport=websocket") as socket_io,
        ):
            await socket_io.send_str("40/action,{}")
            await until(socket_io, "40/action")
            for number, text in [frame[1:] for frame in FRAMES if frame[0] == "→"]:
                request = text.replace("cda973dc.386f4fad", boot)
                await socket_io.send_str(f"42/action,{number}{request}")
                (heard[number],) = json.loads(await until(socket_io, f"43/action,{number}"))
                boot = heard[number].get("boot", boot)
                if number == "3":
                    await until(socket_io, '42/action,["update",{"id":"run-7/dose/1","state":"SUCC')
        process.terminate()
        assert await process.wait() == 0
        return heard

    heard = asyncio.run(talk())
    wanted = {number: json.loads(text)[0] for way, number, text in FRAMES if way == "←" and number}

    assert {n: (a["ok"], a.get("code"), set(a)) for n, a in heard.items()} == {
        n: (a["ok"], a.get("code"), set(a)) for n, a in wanted.items()
    }
    assert heard["4"]["goals"]["run-7/dose/1"]["result"] == {"volume": 1.2}
    assert heard["4"]["goals"]["run-7/dose/2"] is None
