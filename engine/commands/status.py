"""`labrun status [DEVICE|RUN]`: where devices stand, what is wrong with them, and who holds them.

Of a run it prints the line that `labrun runs` has of it.
"""

import asyncio
from collections.abc import Callable, Coroutine, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..exit_status import FAILED, SUCCEEDED
from .options import RUNS, Lab, Runs, WrongUsage, fail, known_device
from .runs import print_runs
from .stop import REACH_S, lab_devices

if TYPE_CHECKING:
    from ..dispatch.serving import Serving

EVERY_S = 1.0


def status(
    device: Annotated[
        str | None, typer.Argument(help="One device, or a run; default: all devices.")
    ] = None,
    follow: Annotated[
        bool, typer.Option("--follow", "-f", help="Again every second, until Ctrl-C.")
    ] = False,
    lab: Lab = None,
    runs: Runs = RUNS,
) -> None:
    """Show state, place, pins, alarm and holder of devices, or how far a run is; nothing is sent."""
    from ..dispatch.serving import servers_of

    loaded, names = lab_devices(lab, None)
    if device is not None:
        if device not in names and _print_run(device, runs, follow):
            return
        try:
            known_device(loaded, device)
        except WrongUsage as fault:
            fail(f"{fault}; and no run is called so, `labrun runs` lists the runs")
        names = [device]

    def find(name: str) -> "list[Serving]":
        return servers_of(loaded, [name], runs)

    shows = [_follow(name, find) if follow else _show(name, find, {}) for name in names]
    answered = asyncio.run(_all(shows))
    none_there = device is not None and answered == [None]
    raise typer.Exit(FAILED if False in answered or none_there else SUCCEEDED)


def _print_run(name: str, runs: Path, follow: bool) -> bool:
    """The run of this name as a line; False where there is none."""
    from ..index.entry import entry_of
    from ..run.folder import FolderFault, find_run

    try:
        folder = find_run(runs, name)
    except FolderFault:
        return False
    if follow:
        fail(f"--follow is for devices; `labrun web` shows how {folder.name} goes on")
    print_runs([entry_of(folder)], folder.parent)
    return True


async def _all(shows: Iterable[Coroutine[Any, Any, bool | None]]) -> list[bool | None]:
    return await asyncio.gather(*shows)


async def _follow(name: str, find: "Callable[[str], list[Serving]]") -> bool | None:
    """Show a device until Ctrl-C; its servers come and go."""
    shown: dict[str, str] = {}
    while True:
        await _show(name, find, shown, follow=True)
        await asyncio.sleep(EVERY_S)


async def _show(
    name: str,
    find: "Callable[[str], list[Serving]]",
    shown: dict[str, str],
    *,
    follow: bool = False,
) -> bool | None:
    """What each server of a device says; whether all answered, None if there is none."""
    servings = find(name)
    if not servings:
        _tell(shown, name, "not served: nobody uses it, and no server of it is known here")
        return None
    several = len(servings) > 1
    watched = [
        _watch(one, f"{name} at {one.url}" if several else name, shown, follow=follow)
        for one in servings
    ]
    return all(await asyncio.gather(*watched))


def _tell(shown: dict[str, str], label: str, line: str) -> None:
    if shown.get(label) != line:
        typer.echo(f"{label:<12} {line}")
    shown[label] = line


async def _watch(serving: "Serving", label: str, shown: dict[str, str], *, follow: bool) -> bool:
    from ...drivers.client.client import DeviceClient, ServerUnreachable

    client, heard = DeviceClient(serving.url, serving.token), False
    try:
        await client.open(REACH_S)
        while True:
            _tell(shown, label, ", ".join(_words((await client.describe())[serving.device])))
            heard = True
            if not follow:
                return True
            await asyncio.sleep(EVERY_S)
    except (ServerUnreachable, KeyError) as fault:
        if not heard:  # of one that has ended since, the next look tells
            _tell(shown, label, f"no answer: {fault}")
        return False
    finally:
        await client.close()


def _words(described) -> Iterator[str]:
    status = dict(described.status)
    state = status.pop("state", None)
    if state is not None or "fault" not in status:
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
