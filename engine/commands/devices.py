"""`labrun devices`: the devices of a lab, and what each can do."""

from typing import Annotated

import typer

from ...schemas.contract import Action, Contract
from ..exit_status import PROBLEMS
from ..lab.lab import LoadedLab, load_lab
from .options import Lab, say


def devices(
    device: Annotated[
        str | None, typer.Argument(help="One device, to list all its actions.")
    ] = None,
    lab: Lab = None,
) -> None:
    """List the lab's devices, or one device's actions with their parameters."""
    loaded, problems = load_lab(lab)
    if loaded is None or problems:
        from ..problems.print import print_problems

        print_problems(problems, format="text")
        if loaded is None or any(problem.severity == "error" for problem in problems):
            raise typer.Exit(PROBLEMS)
    if device is None:
        _list(loaded)
        return
    found = loaded.lab.devices.get(device)
    if found is None:
        say(f"no device {device!r} in this lab; it has {', '.join(loaded.lab.devices)}")
        raise typer.Exit(PROBLEMS)
    _actions(loaded.contracts[found.contract])


def _list(loaded: LoadedLab) -> None:
    for name, device in loaded.lab.devices.items():
        where = device.url or f"driver {device.driver}"
        typer.echo(f"{name:<12} {device.contract:<22} {where}")
    typer.echo("`labrun devices NAME` shows what a device can do")


def _actions(contract: Contract) -> None:
    typer.echo(f"{contract.type}: {contract.summary}")
    for name, action in contract.actions.items():
        typer.echo(f"\n  {name}  ({_nature(action)})\n      {action.summary}")
        for param, schema in action.param_schemas().items():
            need = "" if param in action.required() else ", optional"
            typer.echo(f"      {param}: {_kind(schema)}{need}")
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
    kind = str(schema.get("type", "any"))
    unit = f" in {schema['unit']}" if "unit" in schema else ""
    low, high = schema.get("minimum"), schema.get("maximum")
    limits = f", {low}..{high}" if low is not None and high is not None else ""
    return f"{kind}{unit}{limits}"
