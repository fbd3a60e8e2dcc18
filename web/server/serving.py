"""One port for everything: the gate, then the socket, the API, or the page."""

import asyncio
import contextlib
from collections.abc import Callable, Iterator, MutableMapping
from typing import Any

import socketio

from ...drivers.server import same_user, tokens
from ...drivers.server.gate import split
from ...drivers.server.host import _host_text as host_text
from ...drivers.server.listen import bind, listening
from ...engine.lab.lab import LoadedLab
from ...system.signals import until_end
from ...system.tasks import in_time
from ..access.gate import Gate
from ..app_state.state import AppState, Options, opened
from .app import API, make_app
from .pages import Pages

SOCKET = "/socket.io"
END_S = 10.0


def application(app_state: AppState) -> Gate:
    """The ASGI application of a site."""
    api, pages = make_app(app_state), Pages(app_state.options.page)

    async def answering(scope: MutableMapping[str, Any], receive: Any, send: Any) -> None:
        try:
            await api(scope, receive, send)
        except Exception as fault:  # already answered, and logged here with its traceback
            app_state.faults.note(f"{scope['method']} {scope['path']}", fault)

    async def rest(scope: MutableMapping[str, Any], receive: Any, send: Any) -> None:
        if scope["type"] == "http" and not str(scope["path"]).startswith(API):
            await pages(scope, receive, send)
        elif scope["type"] == "http":
            await answering(scope, receive, send)
        else:
            await send({"type": "websocket.close", "code": 1000})

    both = socketio.ASGIApp(app_state.updates.sio, rest, socketio_path=SOCKET)
    return Gate(both, app_state.sessions, app_state.options.host)


async def serve(options: Options, lab: LoadedLab, ready: Callable[[str, str], None]) -> bool:
    """Serve until a signal; returns whether a live run kept device servers.

    `ready` gets the address to print, and the one to start a browser with. Raises OSError if the port
    is in use or a folder cannot be written.
    """
    listener = bind(options.host, options.port)
    try:
        async with opened(options, lab) as app_state:
            over = until_end()
            url = f"http://{host_text(options.host)}:{listener.getsockname()[1]}"
            async with listening(application(app_state), listener):
                with _let_in(options, url, app_state.sessions.ticket()) as addresses:
                    ready(*addresses)
                    await over.wait()
            if options.demo:
                await _end_runs(app_state)
            return any(
                app_state.device_links.user(name) is not None
                for name in app_state.device_links.links
            )
    finally:
        listener.close()


@contextlib.contextmanager
def _let_in(options: Options, url: str, ticket: str) -> Iterator[tuple[str, str]]:
    """Both addresses; a token that was made here is found by this user's commands meanwhile.

    It stands in the addresses only where the kernel does not tell us our own user's browsers.
    """
    if options.token is None or not options.made_token:
        yield url, url
        return
    with tokens.findable(url, options.token):
        if same_user.is_told((options.host, split(url).port or 0)):
            yield url, url
            return
        yield tokens.with_token(url, options.token), tokens.with_token(url, ticket)


async def _end_runs(app_state: AppState) -> None:
    """The runs of a demonstration end with it, since its folder is deleted."""
    if app_state.runs.live_runs():
        await app_state.stopping.stop_all()
    await in_time(asyncio.gather(*(run.over() for run in app_state.runs.live_runs())), END_S)
