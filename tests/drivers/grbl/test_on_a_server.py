"""The driver behind its device server: held over the wire, paused, stopped by others, missing."""

import asyncio
from contextlib import asynccontextmanager

import pytest

from labrun.drivers.client.client import DeviceClient
from labrun.drivers.server.serve import ServeFault, serving
from labrun.drivers.server.settings import ServerSettings
from labrun.schemas.contracts import shipped_contracts
from labrun.schemas.messages import Goal


def settings(folder, port):
    device = {
        "contract": shipped_contracts()["gantry@1"].model_dump(),
        "driver": "grbl",
        "config": {"port": port, "home_first": True},
    }
    return ServerSettings.model_validate({"devices": {"gantry": device}, "folder": str(folder)})


@asynccontextmanager
async def engine(url):
    """A client that holds the gantry, and makes its goals."""
    client = DeviceClient(url)
    await client.open()
    await client.take_lease("gantry", "test")
    made = iter(range(1000))

    def goal(action, **params):
        return Goal(
            id=f"test/{next(made)}", device="gantry", boot=client.boot,
            epoch=client.epoch("gantry"), action=action, params=params,
        )  # fmt: skip

    try:
        yield client, goal
    finally:
        await client.close()


def test_a_jog_lasts_as_long_as_its_goal_is_sent_again(peers, tmp_path):
    peer = peers(speed=1)

    async def story():
        async with (
            serving(settings(tmp_path, peer.path)) as (_, url),
            engine(url) as (client, goal),
        ):
            await client.follow(goal("home"))
            jog = goal("jog", axis="x", direction="+", feed=600, lease=2)
            ending = asyncio.create_task(client.follow(jog))
            for _ in range(12):
                await asyncio.sleep(0.1)
                kept = await client.keep(jog)
            outcome = await ending
            return kept, outcome, await client.keep(jog)

    kept, outcome, after = asyncio.run(story())

    assert kept is True and after is False
    assert outcome.state == "SUCCEEDED"
    assert 10 < outcome.result["x"] < 400  # of 730
    assert peer.move is None


def test_a_move_is_held_and_let_go_on_while_it_is_under_way(peers, tmp_path):
    peer = peers(speed=2)

    async def story():
        async with (
            serving(settings(tmp_path, peer.path)) as (_, url),
            engine(url) as (client, goal),
        ):
            await client.follow(goal("home"))
            move = asyncio.create_task(client.follow(goal("move_to", x=80)))
            await asyncio.sleep(0.4)
            held = await client.follow(goal("hold"))
            busy = await client.follow(goal("move_to", x=1))
            stood = peer.move is None
            resumed = await client.follow(goal("resume"))
            return held, busy, stood, resumed, await move

    held, busy, stood, resumed, move = asyncio.run(story())

    assert (held.state, resumed.state, move.state) == ("SUCCEEDED",) * 3
    assert busy.error.name == "Busy" and stood
    assert move.result["x"] == pytest.approx(80, abs=0.005)


def test_a_stop_by_somebody_else_reaches_the_axes(peers, tmp_path):
    peer = peers(speed=2)

    async def story():
        async with (
            serving(settings(tmp_path, peer.path)) as (_, url),
            engine(url) as (client, goal),
        ):
            await client.follow(goal("home"))
            move = asyncio.create_task(client.follow(goal("move_to", x=300)))
            await asyncio.sleep(0.5)
            other = DeviceClient(url)
            await other.open()
            told = await other.stop()
            await other.close()
            return told, peer.move is None, await move

    told, stood, move = asyncio.run(story())

    assert told["gantry"][0] is True and stood
    assert move.state == "CANCELED"


def test_a_port_that_is_not_there_keeps_the_server_from_starting(tmp_path):
    async def story():
        with pytest.raises(ServeFault, match="gantry cannot be opened: there is no port /dev/ttyX"):
            async with serving(settings(tmp_path, "/dev/ttyX")):
                pass

    asyncio.run(story())
