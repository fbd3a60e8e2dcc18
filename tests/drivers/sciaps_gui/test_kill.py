"""kill -9 of the device server around the click: one shot a goal at most, and nothing claimed falsely."""

import asyncio
import contextlib
import os
import random
import signal

import pytest

from labrun.drivers.client.client import DeviceClient
from labrun.drivers.client.launch import start_server
from labrun.schemas.contracts import shipped_contracts
from labrun.schemas.messages import Goal

pytestmark = pytest.mark.slow


class KilledServers:
    """Device servers that are killed in mid-shot, one after the other, over one folder."""

    def __init__(self, gui, seed: int) -> None:
        self.gui = gui
        self.draw = random.Random(seed)
        contract = shipped_contracts()["libs_analyzer@1"].model_dump()
        device = {"contract": contract, "driver": "sciaps_gui", "config": gui.config()}
        self.folder = gui.folder / "server"
        self.settings = {"devices": {"libs": device}, "folder": str(self.folder)}

    async def shot(self, goal_id: str) -> str:
        """Ask for one shot and kill its server somewhere on the way; what is known afterwards."""
        server = await start_server(self.settings, self.folder, timeout_s=60)
        client = DeviceClient(server.url, lost_after_s=1.0)
        await client.open(20)
        try:
            await client.take_lease("libs", "run-1")
            following = asyncio.create_task(client.follow(self.goal(client, goal_id, "measure")))
            shot_log = self.folder / "libs" / "shots.sqlite"
            if self.draw.random() < 0.8:
                await self.begun(shot_log, goal_id)
            await asyncio.sleep(self.draw.uniform(0.0, 0.5))
            os.kill(server.pid, signal.SIGKILL)
            await following
        finally:
            await client.close()
            with contextlib.suppress(ProcessLookupError):
                os.kill(server.pid, signal.SIGKILL)
            assert server.process is not None
            await server.process.wait()
        return await self.told(goal_id)

    async def begun(self, shot_log, goal_id: str) -> None:
        """Until the shot stands in the book: the click follows within milliseconds."""
        import sqlite3

        async with asyncio.timeout(500):
            while True:
                with contextlib.suppress(sqlite3.Error):
                    with contextlib.closing(
                        sqlite3.connect(f"file:{shot_log}?mode=ro", uri=True)
                    ) as disk:
                        found = disk.execute(
                            "SELECT 1 FROM shots WHERE goal = ?", (goal_id,)
                        ).fetchone()
                    if found:
                        return
                await asyncio.sleep(0.005)

    async def told(self, goal_id: str) -> str:
        """What the next server's probe says of the goal: fired, not fired, or unknown."""
        server = await start_server(self.settings, self.folder, timeout_s=60)
        client = DeviceClient(server.url)
        await client.open(20)
        try:
            await client.take_lease("libs", "run-1")
            outcome = await client.follow(self.goal(client, f"probe-{goal_id}", "last_shot"))
        finally:
            await client.close()
            await server.stop()
        last = (outcome.result or {}).get("goal_id")
        return "unknown" if last is None else "fired" if last == goal_id else "not fired"

    def goal(self, client: DeviceClient, goal_id: str, action: str) -> Goal:
        return Goal(
            id=goal_id, device="libs", boot=client.boot, epoch=client.epoch("libs"), action=action
        )


def killed_shots(gui, seed: int, rounds: int) -> None:
    analyser = gui.start(measure_s=0.4)
    servers = KilledServers(gui, seed)

    for n in range(rounds):
        before = analyser.shots()
        told = asyncio.run(servers.shot(f"run-1/main/{n}/1"))
        fired = analyser.shots() - before

        assert fired <= 1, f"round {n}: {fired} shots for one goal"
        assert told != "fired" or fired == 1, f"round {n}: told of a shot that was not fired"
        assert told != "not fired" or fired == 0, f"round {n}: a shot was denied"


def test_no_goal_is_shot_twice_and_no_shot_denied_when_its_server_is_killed(gui):
    killed_shots(gui, 1, 2)


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_the_same_over_many_kills(gui):
    killed_shots(gui, 2, 40)
