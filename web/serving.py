"""One port for everything: the gate, then the socket, the API, or the page."""

import asyncio
import contextlib
import signal
import socket
import sys
from collections.abc import Callable, MutableMapping
from typing import Any

import socketio

from ..drivers.host import _host_text as host_text
from ..drivers.listen import bind, listening
from ..engine.lab import LoadedLab
from .app import API, make_app
from .demo.trouble import Trouble
from .guard.gate import Gate
from .opening import opened
from .pages import Pages
from .site import Options, Site

SOCKET = "/socket.io"
END_S = 10.0


def application(site: Site) -> Gate:
    """The ASGI application of a site."""
    api, pages = make_app(site), Pages(site.options.page)

    async def told(scope: MutableMapping[str, Any], receive: Any, send: Any) -> None:
        try:
            await api(scope, receive, send)
        except Exception as fault:  # it was answered: the connection serves the next request
            site.faults.note(f"{scope['method']} {scope['path']}", fault)

    async def rest(scope: MutableMapping[str, Any], receive: Any, send: Any) -> None:
        if scope["type"] == "http" and not str(scope["path"]).startswith(API):
            await pages(scope, receive, send)
        elif scope["type"] == "http":
            await told(scope, receive, send)
        else:
            await send({"type": "websocket.close", "code": 1000})

    both = socketio.ASGIApp(site.push.sio, rest, socketio_path=SOCKET)
    return Gate(both, site.sessions, site.options.host)


async def serve(options: Options, lab: LoadedLab, ready: Callable[[str], None]) -> bool:
    """Serve until a signal; `ready` gets the address. Whether device servers were left to a live run.

    Raises OSError where the port is taken or a folder cannot be written.
    """
    listener = bind(options.host, options.port)
    try:
        async with opened(options, lab) as site:
            if options.demo:
                site.trouble = Trouble(site.bench, options.state / "bench" / "servers" / "world")
            over = _until_signal()
            port = listener.getsockname()[1]
            async with listening(application(site), listener):
                ready(f"http://{host_text(options.host)}:{port}")
                await over.wait()
            if options.demo:
                await _end_runs(site)
            return any(site.bench.user(name) is not None for name in site.bench.stations)
    finally:
        listener.close()


async def _end_runs(site: Site) -> None:
    """The runs of a demonstration end with it: nobody would find them in its folder, which goes."""
    if site.runs.live():
        await site.stopping.stop_all()
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(END_S):
            await asyncio.gather(*(run.over() for run in site.runs.live()))


def _until_signal() -> asyncio.Event:
    over = asyncio.Event()
    loop = asyncio.get_running_loop()
    for name in ("SIGINT", "SIGTERM"):
        number = getattr(signal, name)
        if sys.platform == "win32":
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(over.set))
        else:
            with contextlib.suppress(NotImplementedError):
                loop.add_signal_handler(number, over.set)
    return over


def free(host: str, port: int) -> bool:
    """Whether a port can be had."""
    try:
        with contextlib.closing(bind(host, port)):
            return True
    except (OSError, socket.gaierror):
        return False
