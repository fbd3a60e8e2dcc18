"""`labrun torture FILE`: kill it in every way, and hold what happened against the promise."""

import asyncio
import shutil
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..check import Checked
from ..exit_status import FAILED, PROBLEMS
from .checked import checked_file, told
from .options import RUNS, Lab, Params, Runs, say
from .run import File

if TYPE_CHECKING:
    from ..torture.toll import Toll
    from ..torture.verdict import Breach

SHOWN = 20
ALIKE = 3
"""So many breaches of one line of the promise in one run are told; the rest are counted."""

Kills = Annotated[
    int | None,
    typer.Option("--kills", min=1, help="So many blows; without it one at each journal write."),
]
Seed = Annotated[int, typer.Option("--seed", help="The same seed plans the same blows.")]
Wires = Annotated[
    bool, typer.Option("--wires/--no-wires", help="Every second run also over a bad network.")
]
Keep = Annotated[bool, typer.Option("--keep", help="Keep the folders of runs without a breach.")]


def torture(
    file: File,
    kills: Kills = None,
    seed: Seed = 1,
    param: Params = None,
    lab: Lab = None,
    runs: Runs = RUNS,
    wires: Wires = True,
    keep: Keep = False,
) -> None:
    """Run a protocol on simulated devices, kill engine and servers, resume, and compare."""
    checked = checked_file(file, lab, None, param)
    assert checked.lab is not None
    if not checked.lab.lab.simulated:
        say(
            f"{checked.lab.lab.name} is not a simulated lab: torture kills devices in mid-action. "
            "Leave --lab away, or name a lab that says `simulated: true`."
        )
        raise typer.Exit(PROBLEMS)
    given = told(param, "-p")
    options = [part for name, value in given.items() for part in ("-p", f"{name}={value}")]
    raise typer.Exit(_torture(checked, options, runs, kills, seed, wires=wires, keep=keep))


def _torture(
    checked: Checked, options: list[str], runs: Path, kills: int | None, seed: int, *,
    wires: bool, keep: bool,
) -> int:  # fmt: skip
    from ..run_folder import FolderFault, new_run_folder
    from ..torture.torture import NothingToTorture, Torture

    try:
        name = checked.protocol.name if checked.protocol else ""
        folder = new_run_folder(runs, f"torture-{name}")
    except FolderFault as fault:
        say(str(fault))
        return FAILED
    plan = Torture(checked, options, folder, seed, say, keep=keep, wires=wires)
    try:
        asyncio.run(plan.at_random(kills) if kills else plan.at_every_boundary())
    except KeyboardInterrupt:
        say("stopped: the table is of the runs that are over")
    except NothingToTorture as fault:
        say(str(fault))
        shutil.rmtree(folder, ignore_errors=True)
        return FAILED
    _tell(plan.toll)
    if plan.toll.breaches:
        typer.echo(f"The folders of these runs are kept in {folder}.")
    elif not keep:
        shutil.rmtree(folder, ignore_errors=True)
    return FAILED if plan.toll.breaches else 0


def _tell(toll: "Toll") -> None:
    typer.echo(toll.table())
    shown = first_of_each(toll.breaches)[:SHOWN]
    for breach in shown:
        typer.echo(f"broken: {breach.run}: {breach.text}")
    if len(toll.breaches) > len(shown):
        typer.echo(f"and {len(toll.breaches) - len(shown)} more")


def first_of_each(breaches: "list[Breach]") -> "list[Breach]":
    """The first few of each run and each line of the promise."""
    seen: Counter[tuple[str, str]] = Counter()
    shown = []
    for breach in breaches:
        seen[breach.run, breach.promise] += 1
        if seen[breach.run, breach.promise] <= ALIKE:
            shown.append(breach)
    return shown
