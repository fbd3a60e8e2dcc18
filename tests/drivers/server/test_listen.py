"""What a server keeps of somebody who has not been let in."""

import asyncio
import json

import aiohttp
import pytest

from labrun.drivers.server.listen import FIRST_BYTES

TOKEN = "a token of 24 characters"


@pytest.mark.parametrize(("token", "is_kept"), [(None, False), ("wrong", False), (TOKEN, True)])
def test_a_long_message_is_kept_only_of_a_client_that_was_let_in(bench, token, is_kept):
    async def story():
        settings = {"token": TOKEN}
        async with (
            bench.serving(**settings) as (_, url),
            aiohttp.ClientSession() as session,
            session.ws_connect(f"{url}/socket.io/?EIO=4&transport=websocket") as socket,
        ):
            await socket.receive_str()  # Engine.IO's own greeting
            auth = json.dumps({"token": token})
            if token is not None:
                await socket.send_str(f"40/action,{auth}")
                await socket.receive_str()
            name = "x" * 2 * FIRST_BYTES
            await socket.send_str(f'42/action,1["query",{{"ids":["{name}"]}}]')
            answer = await socket.receive(timeout=500)
            return answer, socket.close_code

    answer, code = asyncio.run(story())

    if is_kept:
        assert answer.type == aiohttp.WSMsgType.TEXT, answer
        assert '"ok":true' in answer.data
    else:
        assert answer.type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED)
        assert code == 1009
