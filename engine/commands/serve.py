"""`labrun serve [LAB] [DEVICE...]`: device servers in the foreground."""

import asyncio
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from ...system.signals import until_end
from ..exit_status import FAILED, NOT_REACHED, SUCCEEDED
from ..lab.lab import LoadedLab
from .options import fail, failing_on, say, usable_lab

FIRST_PORT = 4101


def serve(
    lab: Annotated[
        Path | None, typer.Argument(help="The lab file; without it the simulated lab.")
    ] = None,
    devices: Annotated[
        list[str] | None, typer.Argument(help="Which of its devices; default: all with a driver.")
    ] = None,
    host: Annotated[str, typer.Option(help="The address to listen on.")] = "127.0.0.1",
    port: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=65535,
            show_default=f"{FIRST_PORT}, or the next free one",
            help="The port of the first device; 0 picks free ones.",
        ),
    ] = None,
    token: Annotated[
        str | None,
        typer.Option(
            help="Token that every client must send; or set LABRUN_TOKEN, unseen by `ps`."
        ),
    ] = None,
    token_file: Annotated[
        Path | None, typer.Option(help="The file that holds the token, instead of --token.")
    ] = None,
    folder: Annotated[
        Path | None,
        typer.Option(help="Folder for ledgers and logs.", show_default="one for each lab file"),
    ] = None,
    one: Annotated[bool, typer.Option("--one", help="One server for all the devices.")] = False,
) -> None:
    """Serve a lab's devices until Ctrl-C, then bring each to its safe state."""
    if lab is not None and not lab.exists() and lab.suffix not in (".yaml", ".yml", ".json"):
        devices, lab = [str(lab), *(devices or [])], None
    from ...drivers.server.tokens import WeakToken, chosen

    loaded = usable_lab(lab)
    with failing_on(WeakToken):
        token = chosen(token, token_file, "LABRUN_TOKEN", host)
    configs = _configs(loaded, devices, folder or _home(loaded), host, port, token, one)
    if folder is not None:
        _note(loaded, folder)
    raise typer.Exit(asyncio.run(_serve(configs, loaded)))


EARLIER = Path(".labrun/servers")
"""Where ledgers lay before, in whichever folder the command was given."""


def _home(lab: LoadedLab) -> Path:
    from ..dispatch.served_lab import serve_home

    home = serve_home(lab)
    if EARLIER.is_dir() and not home.exists():
        say(f"{EARLIER} holds earlier ledgers; `--folder {EARLIER}` continues with them")
    return home


def _note(lab: LoadedLab, folder: Path) -> None:
    from ..dispatch.served_lab import serves_in

    try:
        serves_in(lab, folder.resolve())
    except OSError as fault:
        say(f"other commands will find these servers only by their addresses: {fault}")


def _configs(
    lab: LoadedLab, names: list[str] | None, folder: Path, host: str, port: int | None,
    token: str | None, one: bool,
) -> list[dict]:  # fmt: skip
    from ...drivers.server.gate import is_loopback
    from ..dispatch.connect import server_config

    ours = {n: d for n, d in lab.lab.devices.items() if d.driver is not None}
    unknown = [name for name in names or [] if name not in ours]
    if unknown or not ours:
        what = f"no device {unknown[0]!r}" if unknown else "no device with a driver"
        fail(f"{what} to serve in this lab; it has {', '.join(ours) or 'none'}")
    chosen = {name: ours[name] for name in names or ours}
    if one and len({device.python for device in chosen.values()}) > 1:
        fail("devices with different `python` cannot share one server; leave out --one")
    groups = [chosen] if one else [{name: device} for name, device in chosen.items()]
    configs: list[dict] = []
    taken = {device.port for device in ours.values() if device.port is not None}
    for index, group in enumerate(groups):
        config = server_config(group, lab, folder.resolve())
        own = next(iter(group.values())).port
        if own is None and port is None and is_loopback(host):
            at = _next_free(Path(config["folder"]), host, FIRST_PORT + index, taken)
        else:
            at = own or (0 if port == 0 else (port or FIRST_PORT) + index)
            _refuse_taken(Path(config["folder"]), host, at, own is not None)
        taken.add(at)
        config.update(
            host=host, port=at, token=token, owner_pid=os.getpid(), ends_with_owner=True,
            patient=len(chosen) > 1,
        )  # fmt: skip
        configs.append(config)
    return configs


def _next_free(folder: Path, host: str, first: int, taken: set[int]) -> int:
    """The port of a server that was left here, where its clients wait; or one that nobody has.

    This user's commands find a server by its folder, at whatever port.
    """
    from ...drivers.server.listen import free
    from ..dispatch.served_lab import holder_of, live_servers

    for _, words in live_servers(folder):
        return int(words["url"].rpartition(":")[2])
    at = next((at for at in range(first, 65536) if at not in taken and free(host, at)), first)
    if at > first == FIRST_PORT:
        holder = holder_of(first) or "another program"
        say(f"port {first} is in use by {holder}; the next free ones are taken")
    return at


def _refuse_taken(folder: Path, host: str, port: int, by_lab: bool) -> None:
    """End the command where `labrun serve` has another lab at a port that labs of others may name."""
    from ...drivers.server.listen import free
    from ..dispatch.served_lab import holder_of, live_servers

    if not any(live_servers(folder)) and not free(host, port):
        holder = holder_of(port)
        if holder is not None:
            way = "change `port` in the lab" if by_lab else "give another --port"
            fail(f"port {port} is in use by {holder}: end that, or {way}", NOT_REACHED)


async def _serve(configs: list[dict], lab: LoadedLab) -> int:
    from ...drivers.client.launch import RunningServer, ServerFailed
    from ...system.tasks import end, spawn

    over = until_end()
    servers: list[RunningServer] = []
    keeping: list[asyncio.Task[Any]] = []
    asked = spawn("wait for the end", over.wait())
    starting = spawn("start", _start(configs, lab, servers, keeping), expected=(ServerFailed,))
    try:
        await asyncio.wait({asked, starting}, return_when=asyncio.FIRST_COMPLETED)
        if not over.is_set():
            await starting
            await asyncio.wait({asked, *keeping}, return_when=asyncio.FIRST_COMPLETED)
        return SUCCEEDED if over.is_set() else FAILED
    except ServerFailed as fault:
        say(str(fault))
        return NOT_REACHED
    finally:
        await end(asked, starting, *keeping)
        await asyncio.gather(*(server.stop() for server in servers))


async def _start(configs: list[dict], lab: LoadedLab, servers: list, keeping: list) -> None:
    from ...drivers.client.launch import ServerFailed, keep_running, start_patiently
    from ...drivers.server.listen import for_other_machines
    from ...system.tasks import end, spawn
    from ..dispatch.served_lab import starting

    timeout_s = lab.lab.start_timeout_s

    async def start(config: dict) -> None:
        folder, names = Path(config["folder"]), ", ".join(config["devices"])
        server = await start_patiently(config, folder, timeout_s=timeout_s, say=say)
        servers.append(server)
        typer.echo(f"{names} at {server.url}{for_other_machines(config['host'], server.url)}")
        kept = keep_running(server, config, folder, timeout_s=timeout_s)
        keeping.append(spawn(f"keep the server of {names}", kept))

    with starting(lab, [name for config in configs for name in config["devices"]]):
        begun = [spawn("start one", start(one), expected=(ServerFailed,)) for one in configs]
        try:
            await asyncio.gather(*begun)
        finally:
            await end(*begun)
    typer.echo(f"ledgers and logs in {Path(configs[0]['folder']).parent}")
    typer.echo("serving; Ctrl-C stops and leaves the devices safe")
