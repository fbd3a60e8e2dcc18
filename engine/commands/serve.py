"""`labrun serve [LAB] [DEVICE...]`: device servers in the foreground."""

import asyncio
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from ...system import WINDOWS
from ...system.signals import until_end
from ..exit_status import FAILED, NOT_REACHED, PROBLEMS, SUCCEEDED
from ..lab.lab import LoadedLab, load_lab
from .options import say

FIRST_PORT = 4101
ORPHAN_S = 60.0
"""Idle for this long, a server ends if this command was killed; Windows does not report that."""
FIRST_PAUSE_S = 0.5
DEATHS_AT_MOST = 4
CALM_S = 60.0
"""A server that has lived for this long is trusted anew."""


def serve(
    lab: Annotated[
        Path | None, typer.Argument(help="The lab file; without it the simulated lab.")
    ] = None,
    devices: Annotated[
        list[str] | None, typer.Argument(help="Which of its devices; default: all with a driver.")
    ] = None,
    host: Annotated[str, typer.Option(help="The address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="The port of the first device.")] = FIRST_PORT,
    token: Annotated[str | None, typer.Option(help="Token that every client must send.")] = None,
    folder: Annotated[
        Path | None,
        typer.Option(help="Folder for ledgers and logs.", show_default="one for each lab file"),
    ] = None,
    one: Annotated[bool, typer.Option("--one", help="One server for all the devices.")] = False,
) -> None:
    """Serve a lab's devices until Ctrl-C, then bring each to its safe state."""
    if lab is not None and not lab.exists() and lab.suffix not in (".yaml", ".yml", ".json"):
        devices, lab = [str(lab), *(devices or [])], None
    loaded, problems = load_lab(lab)
    if loaded is None or problems:
        from ..problems.print import print_problems

        print_problems(problems, format="text")
        if loaded is None or any(problem.severity == "error" for problem in problems):
            raise typer.Exit(PROBLEMS)
    folder = folder or _home(loaded)
    configs = _configs(loaded, devices, folder, host, port, token, one)
    raise typer.Exit(asyncio.run(_serve(configs, loaded.lab.start_timeout_s)))


EARLIER = Path(".labrun/servers")
"""Where ledgers lay before, in whichever folder the command was given."""


def _home(lab: LoadedLab) -> Path:
    """The same folder wherever the command is given: a device's ledger must be found again."""
    from hashlib import blake2b

    from platformdirs import user_state_path

    name = "simulated"
    if lab.path is not None:
        path = lab.path.resolve()
        name = f"{path.stem}-{blake2b(str(path).encode(), digest_size=4).hexdigest()}"
    home = user_state_path("labrun", appauthor=False) / "servers" / name
    if EARLIER.is_dir() and not home.exists():
        say(f"{EARLIER} holds earlier ledgers; `--folder {EARLIER}` continues with them")
    return home


def _configs(
    lab: LoadedLab, names: list[str] | None, folder: Path, host: str, port: int,
    token: str | None, one: bool,
) -> list[dict]:  # fmt: skip
    from ..dispatch.connect import server_config

    ours = {n: d for n, d in lab.lab.devices.items() if d.driver is not None}
    unknown = [name for name in names or [] if name not in ours]
    if unknown or not ours:
        what = f"no device {unknown[0]!r}" if unknown else "no device with a driver"
        say(f"{what} to serve in this lab; it has {', '.join(ours) or 'none'}")
        raise typer.Exit(PROBLEMS)
    chosen = {name: ours[name] for name in names or ours}
    if one and len({device.python for device in chosen.values()}) > 1:
        say("devices with different `python` cannot share one server; leave out --one")
        raise typer.Exit(PROBLEMS)
    groups = [chosen] if one else [{name: device} for name, device in chosen.items()]
    configs = []
    for index, group in enumerate(groups):
        config = server_config(group, lab, folder.resolve())
        fixed = next(iter(group.values())).port
        config.update(
            host=host, port=fixed or port + index, token=token,
            owner_pid=os.getpid(), idle_exit_s=None if WINDOWS else ORPHAN_S,
        )  # fmt: skip
        configs.append(config)
    return configs


async def _serve(configs: list[dict], timeout_s: float) -> int:
    from ...drivers.client.launch import RunningServer, ServerFailed, start_server
    from ...system.tasks import end, spawn

    over = until_end()
    servers: list[RunningServer] = []
    keeping: list[asyncio.Task[Any]] = []
    try:
        for config in configs:
            server = await start_server(config, Path(config["folder"]), timeout_s=timeout_s)
            servers.append(server)
            typer.echo(f"{', '.join(config['devices'])} at {server.url}")
        typer.echo(f"ledgers and logs in {Path(configs[0]['folder']).parent}")
        typer.echo("serving; Ctrl-C stops and leaves the devices safe")
        for index, config in enumerate(configs):
            name = f"keep the server of {', '.join(config['devices'])}"
            keeping.append(spawn(name, _keep(servers, index, config, timeout_s)))
        asked = spawn("wait for the end", over.wait())
        await asyncio.wait({asked, *keeping}, return_when=asyncio.FIRST_COMPLETED)
        keeping.append(asked)
        return SUCCEEDED if over.is_set() else FAILED
    except ServerFailed as fault:
        say(str(fault))
        return NOT_REACHED
    finally:
        await end(*keeping)
        await asyncio.gather(*(server.stop() for server in servers))


async def _keep(servers: list, index: int, config: dict, timeout_s: float) -> None:
    """Start a server again that has died, after growing pauses; returns when it dies too often."""
    from ...drivers.client.launch import ServerFailed, start_server

    names, clock = ", ".join(config["devices"]), asyncio.get_running_loop().time
    config = {**config, "port": int(servers[index].url.rpartition(":")[2])}
    deaths, pause_s, began = 0, FIRST_PAUSE_S, clock()
    while True:
        await servers[index].ended()
        if clock() - began > CALM_S:
            deaths, pause_s = 0, FIRST_PAUSE_S
        deaths += 1
        log = Path(config["folder"]) / "server.log"
        if deaths > DEATHS_AT_MOST:
            say(f"the server of {names} has died {deaths} times: given up; see {log}")
            return
        say(f"the server of {names} has died, see {log}; it starts again in {pause_s:g} s")
        await asyncio.sleep(pause_s)
        pause_s, began = 2 * pause_s, clock()
        try:
            servers[index] = await start_server(config, log.parent, timeout_s=timeout_s)
        except ServerFailed as fault:
            say(str(fault))
        else:
            say(f"{names} at {servers[index].url} again")
