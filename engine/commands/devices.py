"""`labrun devices`: the devices of a lab, and what each can do."""

import asyncio
from typing import Annotated

import typer

from ...schemas.contract import Action, Contract
from ..lab.lab import LoadedLab
from .options import Lab, WrongUsage, failing_on, known_device, usable_lab
from .status import status_words

ASK_S = 3.0
"""How long a device server may take to say how its devices are."""


def devices(
    device: Annotated[
        str | None, typer.Argument(help="One device, to list all its actions.")
    ] = None,
    lab: Lab = None,
) -> None:
    """List the lab's devices, or one device's actions with their parameters."""
    loaded = usable_lab(lab)
    if device is None:
        _list(loaded)
        return
    with failing_on(WrongUsage):
        _actions(loaded.contracts[known_device(loaded, device).contract])


def _list(loaded: LoadedLab) -> None:
    states = asyncio.run(_states(loaded))
    for name, device in loaded.lab.devices.items():
        where = device.url or f"driver {device.driver}"
        typer.echo(f"{name:<12} {device.contract:<22} {where}")
        if told := states.get(name):
            typer.echo(f"{'':<12} {told}")
    typer.echo("`labrun devices NAME` shows what a device can do")


async def _states(loaded: LoadedLab) -> dict[str, str]:
    """What the devices that are served now say of themselves; those that are not are left out."""
    from ...drivers.client.client import DeviceClient
    from ...drivers.client.link import ServerUnreachable
    from ..dispatch.served_lab import named_at, served_at

    told: dict[str, str] = {}
    for name, device in loaded.lab.devices.items():
        url = named_at(device) or served_at(loaded, name)
        if url is None:
            continue
        client = DeviceClient(url, device.token)
        try:
            await client.open(ASK_S)
            told[name] = ", ".join(status_words(client.devices[name].status))
        except (ServerUnreachable, KeyError) as fault:
            told[name] = f"not reached: {fault}"
        finally:
            await client.close()
    return told


def _actions(contract: Contract) -> None:
    typer.echo(f"{contract.type}: {contract.summary}".rstrip(": "))
    for name, action in contract.actions.items():
        typer.echo(f"\n  {name}  ({_nature(action)})")
        if action.summary:
            typer.echo(f"      {action.summary}")
        for param, schema in action.param_schemas().items():
            need = "" if param in action.required() else ", optional"
            typer.echo(f"      {param}: {_kind(schema)}{need}")
        returned = action.returns.get("properties", {}).items()
        if returned:
            typer.echo("      -> " + "; ".join(f"{n}: {_kind(schema)}" for n, schema in returned))
        if action.errors:
            typer.echo(f"      errors: {', '.join(action.errors)}")


def _nature(action: Action) -> str:
    parts = [action.effect]
    if action.duration:
        parts.append(f"about {action.duration}")
    if action.danger:
        parts.append(f"danger: {action.danger}")
    return ", ".join(parts)


def _kind(schema: dict) -> str:
    if "enum" in schema:
        return " or ".join(str(one) for one in schema["enum"])
    kinds = schema.get("type", "any")
    kind = " or ".join(kinds) if isinstance(kinds, list) else str(kinds)
    unit = f" in {schema['unit']}" if "unit" in schema else ""
    low, high = schema.get("minimum"), schema.get("maximum")
    limits = f", {low}..{high}" if low is not None and high is not None else ""
    if not limits and (low, high) != (None, None):
        limits = f", {high} at most" if low is None else f", {low} at least"
    return f"{kind}{unit}{limits}"
