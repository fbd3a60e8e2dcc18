"""A wrong address, another server, a folder that is not there: a sentence before anything is fired."""

import asyncio
import socket
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest


def opened(driver):
    async def story():
        await driver.open()
        await driver.close()

    asyncio.run(story())


def test_nobody_at_the_address(aecp):
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        aecp.port = probe.getsockname()[1]
    (aecp.folder / "exports").mkdir()

    with pytest.raises(OSError, match=r"analyser server at http://127.0.0.1:\d+ cannot be reached"):
        opened(aecp.driver(connect_s=1))


def test_a_web_server_that_is_something_else(aecp):
    class Other(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_error(404)

        def log_message(self, *_):
            """Nothing: the test's output is its own."""

    (aecp.folder / "exports").mkdir()
    with HTTPServer(("127.0.0.1", 0), Other) as web:
        aecp.port = web.server_port
        thread = threading.Thread(target=web.serve_forever)
        thread.start()
        try:
            with pytest.raises(OSError, match=r"what answers there is not a Socket.IO server"):
                opened(aecp.driver(connect_s=2))
        finally:
            web.shutdown()
            thread.join()


def test_a_socketio_server_that_is_something_else(aecp):
    import socketio
    import uvicorn

    (aecp.folder / "exports").mkdir()
    sio = socketio.AsyncServer(async_mode="asgi")

    async def story():
        config = uvicorn.Config(socketio.ASGIApp(sio), port=0, log_level="critical")
        server = uvicorn.Server(config)
        running = asyncio.create_task(server.serve())
        async with asyncio.timeout(500):
            while not server.started:  # noqa: ASYNC110 - uvicorn has a flag only
                await asyncio.sleep(0.02)
        aecp.port = server.servers[0].sockets[0].getsockname()[1]

        @sio.event
        async def connect(sid, environ):
            await sio.emit("status", {"comms": {"connectionStatus": 2}}, to=sid)

        try:
            with pytest.raises(OSError, match="is not an analyser server: its status is"):
                await aecp.driver().open()
        finally:
            await sio.shutdown()
            server.should_exit = True
            await running

    asyncio.run(story())


def test_an_export_folder_that_is_missing(aecp):
    aecp.start()

    with pytest.raises(
        OSError, match=r"config.exports is '.*cannot be listed: there is no .*/nowhere; is"
    ):
        opened(aecp.driver(exports=str(aecp.folder / "nowhere")))


def test_an_export_path_that_the_server_does_not_have(aecp):
    aecp.start()

    with pytest.raises(OSError, match="was asked to export into 'Z:/nowhere' and answered"):
        opened(aecp.driver(export_path="Z:/nowhere"))


@pytest.mark.parametrize(
    ("config", "words"),
    [
        (
            {"ulr": "http://a"},
            "config has no key ulr; its keys are: url, exports.*perhaps url is meant",
        ),
        ({"url": "localhost:1234"}, "config.url: String should match pattern"),
        ({"measure_s": 0}, "config.measure_s: Input should be greater than 0"),
    ],
)
def test_a_wrong_configuration(aecp, config, words):
    with pytest.raises(ValueError, match=words):
        aecp.driver(**config)
