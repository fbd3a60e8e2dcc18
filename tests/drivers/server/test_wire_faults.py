"""Servers killed and connections cut at any moment: nothing is done twice, no verdict is wrong."""

import asyncio
import os
import random
import signal
import socket
from collections import Counter

import pytest

from labrun.drivers.client.launch import start_server


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


ENOUGH = 20


def succeeded(verdicts):
    return sum(verdict.state == "SUCCEEDED" for verdict in verdicts.values())


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_no_goal_is_done_twice_and_every_verdict_is_true(bench, seed):
    chance = random.Random(seed)
    verdicts = {}

    async def follow_goals(client, done):
        while not done.is_set():
            goal = bench.goal(client, "press", seconds=chance.choice([0, 0, 0.02]))
            verdicts[goal.id] = await client.follow(goal)

    async def story():
        port, done = free_port(), asyncio.Event()
        server = await start_server(bench.settings(port=port), bench.folder)
        async with bench.client(server.url) as client:
            following = asyncio.create_task(follow_goals(client, done))
            for _ in range(5):
                for _ in range(3):
                    await asyncio.sleep(chance.uniform(0.02, 0.2))
                    sio = client._link._sio
                    if sio is not None and sio.eio.ws is not None:
                        await sio.eio.ws.close()
                await asyncio.sleep(chance.uniform(0.05, 0.3))
                os.kill(server.pid, signal.SIGKILL)
                await server.process.wait()
                server = await start_server(bench.settings(port=port), bench.folder)
            async with asyncio.timeout(500):
                while succeeded(verdicts) <= ENOUGH:  # noqa: ASYNC110 - goals end one by one
                    await asyncio.sleep(0.02)
            done.set()
            await following
        await server.stop()

    asyncio.run(story())
    deeds = Counter(deed.removeprefix("arm press ") for deed in bench.deeds() if "press" in deed)
    happened = {i: v.error.happened if v.error else "yes" for i, v in verdicts.items()}

    assert max(deeds.values()) == 1
    assert set(deeds) <= set(verdicts)
    assert {i for i, word in happened.items() if word == "yes"} <= set(deeds)
    assert not {i for i, word in happened.items() if word == "no"} & set(deeds)
    assert succeeded(verdicts) > ENOUGH
