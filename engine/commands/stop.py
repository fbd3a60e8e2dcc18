"""`labrun stop [DEVICE...]`: devices into their safe state, from any shell, past every lease."""

import asyncio
from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import FAILED, PROBLEMS, SUCCEEDED
from .options import RUNS, Lab, Runs, WrongUsage, by_command, failing_on, known_device, say

Devices = Annotated[
    list[str] | None, typer.Argument(metavar="[DEVICE...]", help="Which; default: all of the lab.")
]
REACH_S = 30.0
"""How long a server that is there may take to answer before its device counts as not confirmed."""


def stop(devices: Devices = None, lab: Lab = None, runs: Runs = RUNS) -> None:
    """Stop devices at once, whoever uses them; names each that did not confirm."""
    from ..dispatch.serving import servers_of

    loaded, names = lab_devices(lab, devices)
    servings = servers_of(loaded, names, runs)
    confirmed = asyncio.run(_stop_all(servings)) if servings else []
    unserved = [name for name in names if name not in {one.device for one in servings}]
    for name in unserved:
        say(f"{name}: no server of it is known here, so nothing was sent")
    if not servings:
        say("NOTHING WAS STOPPED. If something moves or fires, use its emergency stop. (Servers of "
            "runs are looked for in --runs, those of another computer by `url` in --lab.)")  # fmt: skip
    # Of all devices those without a server are at rest; one that was named should have been stopped.
    missed = not servings or (devices and unserved)
    raise typer.Exit(FAILED if missed or not all(confirmed) else SUCCEEDED)


def lab_devices(lab: Path | None, devices: list[str] | None):
    """The lab, and the devices that were named, or all of them; ends the command if it cannot."""
    from ..lab.lab import load_lab
    from ..problems.print import print_problems

    loaded, problems = load_lab(lab)
    if loaded is None:
        print_problems(problems, format="text")
        raise typer.Exit(PROBLEMS)
    with failing_on(WrongUsage):
        for name in devices or []:
            known_device(loaded, name)
    return loaded, devices or list(loaded.lab.devices)


async def _stop_all(servings) -> list[bool]:
    by = by_command("stop")
    return await asyncio.gather(*(_stop(serving, by) for serving in servings))


async def _stop(serving, by: str) -> bool:
    from ...drivers.client.client import DeviceClient, ServerUnreachable

    client = DeviceClient(serving.url, serving.token)
    try:
        await client.open(REACH_S)
        confirmed, message = (await client.stop(serving.device, by=by))[serving.device]
    except ServerUnreachable as fault:
        confirmed, message = False, str(fault)
    finally:
        await client.close()
    if confirmed:
        typer.echo(message)
    else:
        say(f"{serving.device} DID NOT CONFIRM: {message}. Use its emergency stop; go and look.")
    return confirmed
