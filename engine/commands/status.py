"""`labrun status [DEVICE]`: where devices stand, what is wrong with them, and who holds them."""

import asyncio
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

import typer

from ..exit_status import FAILED, SUCCEEDED
from .options import RUNS, Lab, Runs
from .stop import REACH_S, lab_devices

EVERY_S = 1.0


def status(
    device: Annotated[str | None, typer.Argument(help="One device; default: all.")] = None,
    follow: Annotated[
        bool, typer.Option("--follow", "-f", help="Again every second, until Ctrl-C.")
    ] = False,
    lab: Lab = None,
    runs: Runs = RUNS,
) -> None:
    """Show state, place, pins, alarm and holder of devices; nothing is sent to them."""
    from ..dispatch.serving import servers_of

    loaded, names = lab_devices(lab, None if device is None else [device])
    servings = servers_of(loaded, names, runs)
    for name in names:
        if name not in {one.device for one in servings}:
            typer.echo(f"{name:<12} not served: nobody uses it, and no server of it is known here")
    if not servings:
        raise typer.Exit(FAILED if device else SUCCEEDED)
    answered = asyncio.run(_show(servings, follow=follow))
    raise typer.Exit(SUCCEEDED if answered else FAILED)


async def _show(servings, *, follow: bool) -> bool:
    names = [serving.device for serving in servings]
    labels = [
        f"{one.device} at {one.url}" if names.count(one.device) > 1 else one.device
        for one in servings
    ]
    watched = map(_watch, servings, labels, [follow] * len(servings))
    return all(await asyncio.gather(*watched))


async def _watch(serving, label: str, follow: bool) -> bool:
    from ...drivers.client.client import DeviceClient, ServerUnreachable

    client = DeviceClient(serving.url, serving.token)
    shown = ""
    try:
        await client.open(REACH_S)
        while True:
            described = (await client.describe())[serving.device]
            line = f"{label:<12} {', '.join(_words(described))}"
            if line != shown:
                typer.echo(line)
            shown = line
            if not follow:
                return True
            await asyncio.sleep(EVERY_S)
    except (ServerUnreachable, KeyError) as fault:
        typer.echo(f"{label:<12} no answer: {fault}")
        return False
    finally:
        await client.close()


def _words(described) -> Iterator[str]:
    status = dict(described.status)
    state = status.pop("state", None)
    yield str(state) if state is not None else "ready"
    yield from status_words(status)
    if described.stopped:
        yield described.stopped
    yield f"held by {described.holder}" if described.holder else "held by nobody"


def status_words(status: Mapping[str, Any]) -> list[str]:
    """What a device tells of itself, name by name; what it does not know is left out."""
    return [
        f"{name} {_value(value)}"
        for name, value in status.items()
        if value not in (None, "", [], {})
    ]


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "(" + ", ".join(f"{name} {_value(one)}" for name, one in value.items()) + ")"
    if isinstance(value, list):
        return ", ".join(_value(one) for one in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
