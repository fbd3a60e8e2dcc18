"""A fault of ours in one frame is told to the client, whose socket and goals go on."""

import asyncio
import json

from websockets.asyncio.client import connect
from websockets.asyncio.server import serve

from labrun.web.ros.bridge.client import Client
from labrun.web.ros.bridge.operations import OPERATIONS
from labrun.web.ros.bridge.rooms import Rooms
from labrun.web.ros.offers.goals import Goals
from labrun.web.ros.offers.offer import Offers


def stumble(client, message):
    raise KeyError("ours")


def test_a_fault_of_ours_is_told_logged_and_no_reason_to_hang_up(caplog):
    rooms = Rooms(Offers(), Goals())

    async def live(socket):
        await Client(socket, rooms).serve_until_gone({**OPERATIONS, "stumble": stumble})

    async def main():
        async with serve(live, "127.0.0.1", 0) as server:
            port = next(iter(server.sockets)).getsockname()[1]
            async with connect(f"ws://127.0.0.1:{port}") as line:
                await line.send(json.dumps({"op": "stumble", "id": "s"}))
                await line.send(json.dumps({"op": "call_service", "service": "rosapi/nodes"}))
                return [json.loads(await line.recv()) for _ in range(2)]

    told, after = asyncio.run(main())

    assert (
        told["op"] == "status"
        and told["id"] == "s"
        and "an internal error in labrun" in told["msg"]
    )
    assert after["values"] == {"nodes": ["/labrun"]}
    assert "KeyError: 'ours'" in caplog.text and "stumble" in caplog.text
