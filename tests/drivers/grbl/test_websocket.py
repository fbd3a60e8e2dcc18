"""FluidNC by its WebSocket: binary messages, texts for its page between them, the newest of a session."""

import asyncio
import contextlib
import threading
from contextlib import contextmanager

import pytest
from serial import Serial
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import serve

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext, Place
from labrun.drivers.grbl import gantry as source
from labrun.drivers.grbl.gantry import Grbl

from ..played import played


@contextmanager
def web_page(peer):
    """A FluidNC's WebSocket before the controller; its address, and its open connections."""
    line, sockets, over = Serial(peer.path, 115200, timeout=0.02), {}, threading.Event()

    def connected(socket):
        session = "independent_session" in socket.request.path and id(socket)
        if (older := sockets.get(session)) is not None:
            older.close()
        sockets[session] = socket
        with contextlib.suppress(ConnectionClosed):
            socket.send("currentID:1")
            socket.send("CURRENT_ID:1")
            for message in socket:
                line.write(message.encode() if isinstance(message, str) else message)
        sockets.pop(session, None)

    def reading():
        while not over.is_set():
            if told := line.readline():
                for socket in list(sockets.values()):
                    with contextlib.suppress(ConnectionClosed):
                        socket.send(told)
                        socket.send("PING\n")

    reader = threading.Thread(target=reading)
    reader.start()
    with serve(connected, "127.0.0.1", 0) as server:
        serving = threading.Thread(target=server.serve_forever)
        serving.start()
        try:
            yield f"ws://127.0.0.1:{server.socket.getsockname()[1]}/", sockets
        finally:
            over.set()
            for socket in list(sockets.values()):
                socket.close()
            server.shutdown()
            serving.join(5)
            reader.join(5)
            line.close()


def test_it_homes_moves_stops_and_comes_back_over_a_websocket(peers, tmp_path, monkeypatch):
    monkeypatch.setattr(source, "AGAIN_S", 0.1)
    peer = peers(fluid=True, boots_on_open=False, speed=4, homing_s=1)

    async def story(driver):
        await driver.home(GoalContext("h"))
        await driver.move_to(GoalContext("1"), x=20)
        await driver.override(GoalContext("o"), feed=120)
        goal = GoalContext("2")
        moving = asyncio.create_task(driver.move_to(goal, x=200))
        await asyncio.sleep(0.4)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled, match="stopped at x"):
            await moving
        status = await driver.status()
        for socket in list(sockets.values()):
            socket.close()
        assert await driver.controller.until(lambda: bool(driver.controller.lost), 5)
        assert await driver.controller.until(lambda: not driver.controller.lost, 5)
        assert await driver.controller.until(lambda: driver.controller.report is not None, 5)
        with pytest.raises(
            ActionFailed, match="its port is being opened again"
        ):  # its reset follows
            await driver.home(GoalContext("too soon"))
        while (await driver.status())["state"] == "offline":  # noqa: ASYNC110 - it has to be asked
            await asyncio.sleep(0.02)
        with pytest.raises(ActionFailed, match=r"is back\. Home it"):
            await driver.move_to(GoalContext("3"), x=1)
        return status

    with web_page(peer) as (url, sockets):
        driver = Grbl(Place("gantry", {"port": url, "boot_s": 0.2}, {}, tmp_path, tmp_path))
        status = played(driver, story)

    assert status["homed"] and 20 < status["x"] < 190
    assert peer.place[0] == pytest.approx(status["x"], abs=0.01)


def test_where_nothing_is_it_says_so(tmp_path):
    place = Place("gantry", {"port": "ws://127.0.0.1:9/"}, {}, tmp_path, tmp_path)

    with pytest.raises(OSError, match=r"ws://127\.0\.0\.1:9/ cannot be reached"):
        asyncio.run(Grbl(place).open())
