"""`labrun ros`: the lab for ROS, through a rosbridge endpoint, or as a node with ROS installed."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...engine.commands.options import fail, failing_on, usable_lab
from ...engine.exit_status import NOT_REACHED
from ..local.options import Host, Lab, Port, TokenFile

if TYPE_CHECKING:
    from ...engine.lab.lab import LoadedLab
    from .offers.offered_lab import Folders

PORT = 9090

Interfaces = Annotated[
    Path | None,
    typer.Option(
        "--interfaces", metavar="DIR", help="Write the lab's interface package to DIR and exit."
    ),
]
Node = Annotated[bool, typer.Option("--node", help="Run as a node of the installed ROS 2.")]
RosArgs = Annotated[
    str,
    typer.Option("--ros-args", help="As of any node: `--ros-args -r __ns:=/bench -r __node:=lab`."),
]
Token = Annotated[
    str | None,
    typer.Option(
        "--token",
        help="Required from every client; or set LABRUN_ROS_TOKEN. On this machine one is made.",
    ),
]
NoToken = Annotated[
    bool,
    typer.Option(
        "--no-token", help="Let in every program of this machine, for clients that send none."
    ),
]
Origin = Annotated[
    list[str] | None,
    typer.Option("--origin", help="A site whose pages may connect, besides those of this machine."),
]
Protocols = Annotated[
    Path, typer.Option("--protocols", help="Folder of protocols that may be run.")
]
Runs = Annotated[Path, typer.Option("--runs", help="Folder for the run folders.")]
Files = Annotated[
    Path, typer.Option("--files", help="Folder of files that actions read and write.")
]
State = Annotated[Path, typer.Option("--state", help="Folder for ports, ledgers and logs.")]


def ros(
    lab: Lab = None,
    interfaces: Interfaces = None,
    node: Node = False,
    ros_args: RosArgs = "",
    port: Port = PORT,
    host: Host = "127.0.0.1",
    token: Token = None,
    token_file: TokenFile = None,
    no_token: NoToken = False,
    origin: Origin = None,
    protocols: Protocols = Path(),
    runs: Runs = Path("runs"),
    files: Files = Path(".labrun/ros/files"),
    state: State = Path(".labrun/ros"),
) -> None:
    """Offer the lab to ROS: every device action, its status, and whole protocols."""
    loaded = usable_lab(lab)
    package = _package(loaded)
    if interfaces is not None:
        _write(loaded, package, interfaces)
        return
    from .offers.offered_lab import Folders

    folders = Folders(protocols.resolve(), runs.resolve(), files.resolve(), state.resolve())
    if not folders.protocols.is_dir():
        fail(f"--protocols {protocols} is not a folder")
    if node:
        from .as_node import run_node

        words = shlex.split(ros_args)
        _run(run_node(loaded, package, folders, words, typer.echo), "the state folder")
    elif ros_args:
        fail("--ros-args are for a node of ROS: add --node")
    else:
        from ...drivers.server.tokens import WeakToken, for_port

        with failing_on(WeakToken):
            known = for_port(token, token_file, "LABRUN_ROS_TOKEN", host, open_to_all=no_token)
        _run(_bridge(loaded, package, folders, host, port, known, origin or []), f"{host}:{port}")


def _package(lab: "LoadedLab") -> str:
    from .interfaces.kinds import PACKAGE

    return lab.lab.ros.package if lab.lab.ros is not None else PACKAGE


def _write(lab: "LoadedLab", package: str, folder: Path) -> None:
    from .write_interfaces import write_interfaces

    try:
        written = write_interfaces(lab, package, folder)
    except OSError as fault:
        fail(f"{fault.filename or folder} cannot be written: {fault.strerror}", NOT_REACHED)
    for place in written:
        typer.echo(f"{place}")
    typer.echo(
        f"build them in a workspace: colcon build --packages-select {' '.join(p.name for p in written)}"
    )


async def _bridge(
    lab: "LoadedLab", package: str, folders: "Folders", host: str, port: int,
    known: tuple[str | None, bool], origins: list[str],
) -> None:  # fmt: skip
    from contextlib import ExitStack
    from urllib.parse import urlsplit

    from ...drivers.server.same_user import is_told
    from ...drivers.server.tokens import findable, with_token
    from ...system.signals import until_end
    from .bridge.gate import Brake, Gate
    from .bridge.serve import ask_for, bridge
    from .offers.greeting import greeting
    from .open_lab import opened

    token, made = known
    over = until_end()
    await ask_for(host, port)
    async with (
        opened(lab, package, folders) as offered,
        bridge(
            offered.offers, offered.goals, Gate(host, Brake(token), frozenset(origins), made), port
        ) as address,
    ):
        with ExitStack() as keeping:
            if token is not None and made:
                keeping.enter_context(findable(address, token))
                if not is_told((host, urlsplit(address).port or 0)):
                    address = with_token(address, token)
            typer.echo(f"labrun ros at {address}")
            for line in greeting(offered):
                typer.echo(line)
            await over.wait()


def _run(work: Any, what: str) -> None:
    import asyncio
    import logging

    from .interfaces.fault import RosFault

    logging.basicConfig(format="labrun: %(message)s", level=logging.WARNING)
    logging.getLogger("websockets").setLevel(
        logging.CRITICAL
    )  # a stranger's bad handshake is not worth a log line
    try:
        with failing_on(RosFault):
            asyncio.run(work)
    except OSError as fault:
        words = fault.strerror or str(fault)
        fail(f"{fault.filename or what} cannot be used: {words}", NOT_REACHED)
