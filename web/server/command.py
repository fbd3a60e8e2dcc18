"""`labrun web`: the page, and the API behind it, on one port."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...engine.commands.options import fail, failing_on, usable_lab
from ...engine.exit_status import NOT_REACHED
from ..local.options import Folder, Host, Lab, Runs, TokenFile, protocol_folder

if TYPE_CHECKING:
    from ..app_state.state import Options

PORT = 8321
NEXT = 20
"""So many ports from the first one are looked at."""
ANSWERS_S = 2.0

Token = Annotated[
    str | None,
    typer.Option(
        "--token",
        help="Required from every browser; or set LABRUN_WEB_TOKEN. On this machine one is made.",
    ),
]
NoToken = Annotated[
    bool,
    typer.Option("--no-token", help="Let in every user and program of this machine, unasked."),
]
Demo = Annotated[
    bool, typer.Option("--demo", help="Serve a simulated bench with data in a temporary folder.")
]
Speed = Annotated[
    float,
    typer.Option(
        "--speed", min=0, help="Speed of the demo as a multiple of real time; 0: no waiting."
    ),
]
CheckTimeout = Annotated[
    float,
    typer.Option(
        "--check-timeout", min=1, metavar="S", help="Time for one check of a protocol, in s."
    ),
]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Do not open a browser.")]
FirstFree = Annotated[
    int | None,
    typer.Option(
        "--port", min=0, max=65535, show_default=f"{PORT}, or the next free one",
        help="0 picks a free port.",
    ),
]  # fmt: skip


def web(
    folder: Folder = None,
    port: FirstFree = None,
    host: Host = "127.0.0.1",
    token: Token = None,
    token_file: TokenFile = None,
    no_token: NoToken = False,
    lab: Lab = None,
    runs: Runs = None,
    demo: Demo = False,
    speed: Speed = 10.0,
    check_timeout: CheckTimeout = 60.0,
    no_browser: NoBrowser = False,
) -> None:
    """Serve the page to edit, launch, watch and review; runs continue without it."""
    from ...drivers.server.tokens import WeakToken, for_port
    from ...system.start import spare_of_socketio

    spare_of_socketio()
    if token is not None:  # crash logs show the command line
        sys.argv = [part.replace(token, "***") for part in sys.argv]
    with failing_on(WeakToken):
        known = for_port(token, token_file, "LABRUN_WEB_TOKEN", host, open_to_all=no_token)
    if demo and (folder is not None or lab is not None or runs is not None):
        fail("--demo has its own protocols, lab and runs: omit the folder, --lab and --runs")
    if demo:
        from ..demo.demo import demonstration

        with demonstration(speed) as (protocols, demo_lab):
            options = _options(
                protocols, host, port, known, demo_lab, None, check_timeout, demo=True
            )
            _serve(options, browser=not no_browser)
        return
    options = _options(protocol_folder(folder), host, port, known, lab, runs, check_timeout)
    _serve(options, browser=not no_browser)


def _options(
    protocols: Path, host: str, port: int | None, known: tuple[str | None, bool], lab: Path | None,
    runs: Path | None, check_timeout_s: float, *, demo: bool = False,
) -> "Options":  # fmt: skip
    from ..app_state.state import Options

    if port is None:
        port = _next_free(host, protocols)
    return Options(
        protocols=protocols, runs=(runs or protocols / "runs").resolve(),
        lab=lab.resolve() if lab is not None else None,
        host=host, port=port, token=known[0], made_token=known[1], demo=demo,
        check_timeout_s=check_timeout_s,
    )  # fmt: skip


def _next_free(host: str, protocols: Path) -> int:
    """The first port that is free; ends the command where a page of the same folder is at one before it."""
    from ...drivers.server.listen import free
    from ...drivers.server.tokens import found, with_token

    for port in range(PORT, PORT + NEXT):
        if free(host, port):
            if port != PORT:
                typer.echo(f"port {PORT} is in use; --port chooses another one")
            return port
        url = f"http://{host}:{port}"
        if (token := found(url)) is not None and _folder_at(url, token) == str(protocols):
            fail(
                f"{protocols} has its page already: open {with_token(url, token)}, or start "
                "another one with --port 0",
                NOT_REACHED,
            )
    return PORT


def _folder_at(url: str, token: str) -> str | None:
    """The folder that the page at an address serves, as it says itself."""
    import json
    from urllib.request import ProxyHandler, Request, build_opener

    asked = Request(f"{url}/api/v1/settings", headers={"Authorization": f"Bearer {token}"})
    try:
        with build_opener(ProxyHandler({})).open(asked, timeout=ANSWERS_S) as answer:
            return json.load(answer)["about"]["protocols"]
    except (OSError, ValueError, LookupError, TypeError):  # another program, or none that answers
        return None


def _serve(options: "Options", *, browser: bool) -> None:
    import asyncio
    import logging

    from ...drivers.server.listen import for_other_machines
    from ...system.page import HOW, why_no_page
    from ..access.once import UnreadableKeys
    from .serving import serve

    logging.basicConfig(format="labrun: %(message)s", level=logging.WARNING)
    lab = usable_lab(options.lab)

    def ready(address: str, first: str) -> None:
        typer.echo(f"labrun web at {address}{for_other_machines(options.host, address)}")
        typer.echo(
            f"protocols in {options.protocols}, runs in {options.runs}; press Ctrl-C to stop"
        )
        if (why := why_no_page(options.page)) is not None:
            typer.echo(
                f"the page is not built{why and f' ({why})'}, only the API works: {HOW}", err=True
            )
        if browser:
            import webbrowser

            webbrowser.open(first)

    try:
        left = asyncio.run(serve(options, lab, ready))
    except OSError as fault:
        fail(_why_not(fault, options), NOT_REACHED)
    except UnreadableKeys as fault:
        fail(str(fault))
    if left:
        typer.echo("a run is still going; its engine and devices stay up, see `labrun runs`")
        # A normal exit of the interpreter would kill the device servers that the run needs.
        os._exit(0)


def _why_not(fault: OSError, options: "Options") -> str:
    import errno

    from ...drivers.server.tokens import found, with_token

    words = fault.strerror or str(fault)
    where = f"{options.host}:{options.port}"
    if fault.errno == errno.EADDRINUSE:
        url = f"http://{where}"
        token = found(url)
        which = "open that one" if token is None else f"open {with_token(url, token)}"
        return (
            f"{where} is already in use, perhaps by another `labrun web`: {which}, or "
            "use a free port with --port 0"
        )
    if fault.filename is not None:
        way_on = ""
        if fault.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
            way_on = "; serve a folder in which you may write, such as a copy of this one"
        return f"{fault.filename} cannot be used: {words}{way_on}"
    return f"cannot listen on {where}, or a folder cannot be used: {words}"
