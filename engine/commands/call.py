"""`labrun call gantry.move_to x="10 mm"`: one action by hand."""

import asyncio
import json
import secrets
import shutil
import sys
import tempfile
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...system.signals import on_end
from ..exit_status import CTRL_C, FAILED, NOT_REACHED, PROBLEMS, SUCCEEDED
from ..lab.lab import LoadedLab
from .options import RUNS, Lab, WrongUsage, fail, known_device, pairs, say, usable_lab
from .status import status_words

if TYPE_CHECKING:
    from ...drivers.client.client import DeviceClient, Outcome
    from ...schemas.contract import Action, Contract
    from ...schemas.messages import Goal

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
    from ..language.arguments import ArgumentFaults, typed

    loaded = usable_lab(lab)
    device, _, name = action.partition(".")
    try:
        found = find_action(loaded, device, name)
        schemas = found.param_schemas()
        given = {n: typed(text, schemas.get(n, {})) for n, text in pairs(params, "").items()}
        arguments = fitted(loaded, device, name, given)
    except (WrongUsage, ArgumentFaults) as fault:
        fail(str(fault).strip())
    if found.danger and not yes and not _armed(action, found.danger):
        fail(f"{action} is dangerous ({found.danger}); `--yes` confirms it")
    raise typer.Exit(asyncio.run(_call(loaded, device, name, arguments)))


def find_action(lab: LoadedLab, device: str, name: str) -> "Action":
    """An action of a device; raises WrongUsage with what there is instead."""
    from ..language.suggest import did_you_mean

    contract = lab.contracts[known_device(lab, device).contract]
    if name not in contract.actions:
        raise WrongUsage(
            f"{device!r} has no action {name!r}{did_you_mean(name, contract.actions)}; "
            f"it has {', '.join(contract.actions)}"
        )
    return contract.actions[name]


def fitted(lab: LoadedLab, device: str, name: str, given: dict[str, Any]) -> dict[str, Any]:
    """The arguments as the driver gets them, within this bench's limits; raises ArgumentFaults."""
    from ..language.arguments import resolve_arguments

    limits = lab.lab.devices[device].limits
    return resolve_arguments(
        find_action(lab, device, name), given, limits, label=f"{device}.{name}"
    )


def _armed(action: str, danger: str) -> bool:
    return sys.stdin.isatty() and typer.confirm(f"{action} is dangerous ({danger}). Do it?")


@dataclass(frozen=True, slots=True)
class Called:
    """How one action by hand ended; `cancelled_by` if it was asked to.

    `standing`: where its device stands, if the action was cancelled, or stopped by somebody.
    """

    label: str
    outcome: "Outcome"
    cancelled_by: str = ""
    standing: str = ""

    @property
    def ok(self) -> bool:
        """Whether it came to its own end, and succeeded."""
        return not self.cancelled_by and self.outcome.state == "SUCCEEDED"

    @property
    def words(self) -> list[str]:
        """What to tell a person of one that did not."""
        error, state = self.outcome.error, self.outcome.state
        why = f": {error.message}" if error else ""
        if self.cancelled_by:
            told = [f"{self.label} was cancelled by {self.cancelled_by} and ended {state}{why}"]
        else:
            told = [f"{self.label}: {error.name}{why}" if error else f"ended {state}"]
        if self.cancelled_by or self.standing:
            device = self.label.partition(".")[0]
            told.append(f"{device} now: {self.standing or 'its status is not known'}")
        return told


async def _call(lab: LoadedLab, device: str, name: str, arguments: dict[str, Any]) -> int:
    from ..dispatch.connect import NotReached, connect
    from ..run.names import FileFault

    with ExitStack() as leaving:
        folder = tempfile.mkdtemp(prefix="labrun-call-")
        leaving.callback(shutil.rmtree, folder, ignore_errors=True)
        owner = f"call-{secrets.token_hex(4)}"
        role = role_of(lab, device)
        try:
            connections = await connect(
                {device: role}, lab, Path(folder), owner, say=say, found=used_at(lab, device)
            )
        except NotReached as fault:
            say(f"{fault}. Nothing was sent.")
            return NOT_REACHED
        except asyncio.CancelledError:
            say("Ctrl-C: nothing was sent")
            raise
        try:
            client = connections.clients[device]
            id = f"{owner}/{name}/1"
            called = await do_action(client, role.contract, device, name, arguments, id)
            error = called.outcome.error
            if error is not None and folder in error.message:
                leaving.pop_all()  # it holds a picture of what was seen
        except FileFault as fault:
            say(str(fault))
            return PROBLEMS
        finally:
            await connections.close()
    if called.ok:
        typer.echo(json.dumps(called.outcome.result, indent=1))
        return SUCCEEDED
    for line in called.words:
        say(line)
    return CTRL_C if called.cancelled_by == "Ctrl-C" else FAILED


def role_of(lab: LoadedLab, device: str):
    """A device in the role of itself."""
    from ..lab.bind import BoundRole

    contract = lab.contracts[lab.lab.devices[device].contract]
    return BoundRole(device, device, contract, lab.lab.devices[device].limits)


def used_at(lab: LoadedLab, device: str) -> dict[str, str]:
    """The address where somebody uses a device now, by its name, if anybody does."""
    from ..dispatch.serving import servers_of

    if lab.path is None:
        return {}  # the simulated lab is each command's own
    return {serving.device: serving.url for serving in servers_of(lab, [device], RUNS)}


async def do_action(
    client: "DeviceClient", contract: "Contract", device: str, name: str, arguments: dict[str, Any],
    id: str, *, hear: Callable[[Callable[[str], object]], Callable[[], None]] = on_end,
    say: Callable[[str], None] = say,
) -> Called:  # fmt: skip
    """Send one goal and follow it to its end; files are read from and written to the current folder.

    `hear` is given what cancels the goal, and returns what takes that back. Raises FileFault.
    """
    from ...schemas.messages import Goal
    from ..run.files import read_content, write_content

    read, _ = contract.actions[name].path_params()
    goal = Goal(
        id=id, device=device, boot=client.boot, epoch=client.epoch(device), action=name,
        params=arguments, files={n: read_content(Path(), arguments[n]) for n in read if n in arguments},
    )  # fmt: skip
    outcome, by = await _followed(client, goal, contract.cancel_grace_s, hear, say)
    stopped = outcome.error is not None and outcome.error.name == "Stopped"
    standing = await _standing(client, device) if by or stopped else ""
    for content in outcome.files.values():
        write_content(Path(), content)
    return Called(f"{device}.{name}", outcome, by, standing)


async def _followed(
    client: "DeviceClient", goal: "Goal", grace_s: float, hear: Callable, say: Callable[[str], None]
) -> "tuple[Outcome, str]":
    """The goal's outcome, and what ended it early: it is cancelled, and stopped if that does not help."""
    from ...system.tasks import spawn

    cancel_s = max(CANCEL_S, grace_s + 2)
    asked: asyncio.Future[str] = asyncio.get_running_loop().create_future()
    deaf = hear(lambda by: None if asked.done() else asked.set_result(by))
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
    return ", ".join(status_words(client.status.get(device, {})))
