"""`labrun call gantry.move_to x="10 mm"`: one action by hand."""

import asyncio
import json
import secrets
import shutil
import sys
import tempfile
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Annotated, Any

import typer

from ..exit_status import CTRL_C, FAILED, NOT_REACHED, PROBLEMS, SUCCEEDED
from ..lab.lab import LoadedLab
from .options import Lab, WrongUsage, pairs, say, usable_lab

CANCEL_S = 10.0
"""How long a cancelled action may take to end before its device is stopped, unless its contract says."""
STATUS_S = 5.0
"""How long to wait for the status of a device, which is sent every second."""


def call(
    action: Annotated[str, typer.Argument(metavar="DEVICE.ACTION")],
    params: Annotated[list[str] | None, typer.Argument(metavar="NAME=VALUE...")] = None,
    lab: Lab = None,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Confirm a dangerous action.")] = False,
) -> None:
    """Run one action on one device, with the same checks as in a protocol."""
    from ..language.arguments import ArgumentFaults, resolve_arguments, typed

    loaded = usable_lab(lab)
    device, _, name = action.partition(".")
    try:
        found = _find(loaded, device, name)
        schemas = found.param_schemas()
        given = {n: typed(text, schemas.get(n, {})) for n, text in pairs(params, "").items()}
        limits = loaded.lab.devices[device].limits
        arguments = resolve_arguments(found, given, limits, label=action)
    except (WrongUsage, ArgumentFaults) as fault:
        say(str(fault).strip())
        raise typer.Exit(PROBLEMS) from None
    if found.danger and not yes and not _armed(action, found.danger):
        say(f"{action} is dangerous ({found.danger}); `--yes` confirms it")
        raise typer.Exit(PROBLEMS)
    raise typer.Exit(asyncio.run(_call(loaded, device, name, arguments)))


def _find(lab: LoadedLab, device: str, name: str):
    from ..language.suggest import did_you_mean

    if device not in lab.lab.devices:
        raise WrongUsage(
            f"no device {device!r} in this lab{did_you_mean(device, lab.lab.devices)}; "
            f"it has {', '.join(lab.lab.devices)}"
        )
    contract = lab.contracts[lab.lab.devices[device].contract]
    if name not in contract.actions:
        raise WrongUsage(
            f"{device!r} has no action {name!r}{did_you_mean(name, contract.actions)}; "
            f"it has {', '.join(contract.actions)}"
        )
    return contract.actions[name]


def _armed(action: str, danger: str) -> bool:
    return sys.stdin.isatty() and typer.confirm(f"{action} is dangerous ({danger}). Do it?")


async def _call(lab: LoadedLab, device: str, name: str, arguments: dict[str, Any]) -> int:
    from ...schemas.messages import Goal
    from ..dispatch.connect import NotReached, connect
    from ..lab.bind import BoundRole
    from ..run.files import read_content, write_content
    from ..run.names import FileFault

    contract = lab.contracts[lab.lab.devices[device].contract]
    role = BoundRole(device, device, contract, lab.lab.devices[device].limits)
    action = contract.actions[name]
    with ExitStack() as leaving:
        folder = tempfile.mkdtemp(prefix="labrun-call-")
        leaving.callback(shutil.rmtree, folder, ignore_errors=True)
        owner = f"call-{secrets.token_hex(4)}"
        try:
            connections = await connect({device: role}, lab, Path(folder), owner, say=say)
        except NotReached as fault:
            say(f"{fault}. Nothing was sent.")
            return NOT_REACHED
        try:
            client = connections.clients[device]
            read, _ = action.path_params()
            files = {n: read_content(Path(), arguments[n]) for n in read if n in arguments}
            goal = Goal(
                id=f"{owner}/{name}/1", device=device, boot=client.boot,
                epoch=client.epoch(device), action=name, params=arguments, files=files,
            )  # fmt: skip
            outcome, ended_by = await _followed(client, goal, contract.cancel_grace_s)
            standing = await _standing(client, device) if ended_by else ""
            for content in outcome.files.values():
                write_content(Path(), content)
            if outcome.error is not None and folder in outcome.error.message:
                leaving.pop_all()  # it holds a picture of what was seen
        except FileFault as fault:
            say(str(fault))
            return PROBLEMS
        finally:
            await connections.close()
    if ended_by:
        words = f": {outcome.error.message}" if outcome.error else ""
        say(f"{device}.{name} was cancelled by {ended_by} and ended {outcome.state}{words}")
        say(f"{device} now: {standing or 'its status is not known'}")
        return CTRL_C if ended_by == "Ctrl-C" else FAILED
    if outcome.state == "SUCCEEDED":
        typer.echo(json.dumps(outcome.result, indent=1))
        return SUCCEEDED
    error = outcome.error
    say(f"{device}.{name}: {error.name}: {error.message}" if error else f"ended {outcome.state}")
    return FAILED


async def _followed(client, goal, grace_s: float) -> tuple[Any, str]:
    """The goal's outcome, and what ended it early: it is cancelled, and stopped if that does not help."""
    from ...system.signals import on_end
    from ...system.tasks import spawn

    cancel_s = max(CANCEL_S, grace_s + 2)
    asked: asyncio.Future[str] = asyncio.get_running_loop().create_future()
    deaf = on_end(lambda by: None if asked.done() else asked.set_result(by))
    following = spawn(f"follow {goal.id}", client.follow(goal, lambda report: None))
    try:
        await asyncio.wait({following, asked}, return_when=asyncio.FIRST_COMPLETED)
        if following.done():
            return following.result(), ""
        say(f"{asked.result()}: cancelling {goal.device}.{goal.action}")
        await client.cancel(goal.id)
        done, _ = await asyncio.wait({following}, timeout=cancel_s)
        if not done:
            say(f"{goal.device} does not end it within {cancel_s:g} s: stopping {goal.device}")
            safe, message = (await client.stop(goal.device))[goal.device]
            say(f"{goal.device} is in its safe state" if safe else f"{message}. Go and look.")
        return await following, asked.result()
    finally:
        deaf()


async def _standing(client, device: str) -> str:
    """Where a device stands now that its action has ended: its second status from now on.

    The first may have been on its way before the end.
    """
    with suppress(TimeoutError):
        async with asyncio.timeout(STATUS_S):
            for _ in range(2):
                before = client.status.get(device)
                while client.status.get(device) is before:  # noqa: ASYNC110 - none may come
                    await asyncio.sleep(0.02)
    status = client.status.get(device, {})
    return ", ".join(f"{name} {value}" for name, value in status.items() if value not in (None, ""))
