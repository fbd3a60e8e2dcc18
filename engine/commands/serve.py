"""`labrun serve [LAB] [DEVICE...]`: device servers in the foreground."""

import asyncio
import os
import signal
import sys
from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import NOT_REACHED, PROBLEMS, SUCCEEDED
from ..lab import LoadedLab, load_lab
from .options import say

FIRST_PORT = 4101
ORPHAN_S = 60.0
"""Calm for so long, a server ends where this command was killed; Windows does not tell that."""


def serve(
    lab: Annotated[
        Path | None, typer.Argument(help="The lab file; without it the simulated lab.")
    ] = None,
    devices: Annotated[
        list[str] | None, typer.Argument(help="Which of its devices; all with a driver if none.")
    ] = None,
    host: Annotated[str, typer.Option(help="The address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="The port of the first device.")] = FIRST_PORT,
    token: Annotated[str | None, typer.Option(help="Wanted from every client.")] = None,
    folder: Annotated[Path, typer.Option(help="For ledgers and logs.")] = Path(".labrun/servers"),
    one: Annotated[bool, typer.Option("--one", help="One server for all the devices.")] = False,
) -> None:
    """Serve a lab's devices until Ctrl-C; each is in its safe state then."""
    if lab is not None and not lab.exists() and lab.suffix not in (".yaml", ".yml", ".json"):
        devices, lab = [str(lab), *(devices or [])], None
    loaded, problems = load_lab(lab)
    if loaded is None or problems:
        from ..print_problems import print_problems

        print_problems(problems, format="text")
        if loaded is None or any(problem.severity == "error" for problem in problems):
            raise typer.Exit(PROBLEMS)
    raise typer.Exit(asyncio.run(_serve(_configs(loaded, devices, folder, host, port, token, one))))


def _configs(
    lab: LoadedLab, names: list[str] | None, folder: Path, host: str, port: int,
    token: str | None, one: bool,
) -> list[dict]:  # fmt: skip
    from ..connect import server_config

    ours = {n: d for n, d in lab.lab.devices.items() if d.driver is not None}
    unknown = [name for name in names or [] if name not in ours]
    if unknown or not ours:
        what = f"no device {unknown[0]!r}" if unknown else "no device with a driver"
        say(f"{what} to serve in this lab; it has {', '.join(ours) or 'none'}")
        raise typer.Exit(PROBLEMS)
    chosen = {name: ours[name] for name in names or ours}
    groups = [chosen] if one else [{name: device} for name, device in chosen.items()]
    configs = []
    for index, group in enumerate(groups):
        config = server_config(group, lab, folder.resolve())
        fixed = next(iter(group.values())).port
        config.update(
            host=host, port=fixed or port + index, token=token,
            owner_pid=os.getpid(), idle_exit_s=None if sys.platform == "win32" else ORPHAN_S,
        )  # fmt: skip
        configs.append(config)
    return configs


async def _serve(configs: list[dict]) -> int:
    from ...drivers.launch import RunningServer, ServerFailed, start_server

    loop = asyncio.get_running_loop()
    over = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, over.set)
    servers: list[RunningServer] = []
    try:
        for config in configs:
            server = await start_server(config, Path(config["folder"]))
            servers.append(server)
            typer.echo(f"{', '.join(config['devices'])} at {server.url}")
        typer.echo("serving; Ctrl-C ends it and leaves the devices safe")
        await over.wait()
        return SUCCEEDED
    except ServerFailed as fault:
        say(str(fault))
        return NOT_REACHED
    finally:
        await asyncio.gather(*(server.stop() for server in servers))
