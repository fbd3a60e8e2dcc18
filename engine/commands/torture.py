"""`labrun torture FILE`: kill it in every way, and compare what happened with the promise."""

import asyncio
import shutil
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...system import WINDOWS
from ..check import Checked
from ..exit_status import FAILED, PROBLEMS
from .checked_protocol import checked_file
from .options import RUNS, Lab, Params, Runs, fail, pairs, say

if TYPE_CHECKING:
    from ..torture.report import Report
    from ..torture.verdict import Breach

SHOWN = 20
ALIKE = 3
"""At most this many breaches of a line of the promise are shown per run; the rest are counted."""

File = Annotated[
    Path | None,
    typer.Argument(metavar="FILE", help="The protocol; with --simulate, random ones if left out."),
]
Simulate = Annotated[
    int | None,
    typer.Option(
        "--simulate",
        min=1,
        metavar="N",
        help="Instead of real processes: N simulated histories, from --seed on, each by its own seed.",
    ),
]
Kills = Annotated[
    int | None,
    typer.Option("--kills", min=1, help="Number of kills; default: one at each journal write."),
]
Seed = Annotated[int, typer.Option("--seed", help="The same seed plans the same kills.")]
Wires = Annotated[
    bool, typer.Option("--wires/--no-wires", help="Every second run also uses a bad network.")
]
Keep = Annotated[bool, typer.Option("--keep", help="Keep the folders of runs without a breach.")]


def torture(
    file: File = None,
    kills: Kills = None,
    simulate: Simulate = None,
    seed: Seed = 1,
    param: Params = None,
    lab: Lab = None,
    runs: Runs = RUNS,
    wires: Wires = True,
    keep: Keep = False,
) -> None:
    """Run a protocol on simulated devices, kill the engine and servers, resume, and compare."""
    if simulate is not None:
        checked = None if file is None else checked_file(file, lab, None, param)
        raise typer.Exit(_simulate(range(seed, seed + simulate), checked))
    if file is None:
        fail("name a protocol, or add --simulate N for random ones")
    if WINDOWS:
        fail(
            "torture needs SIGKILL, which Windows does not have. Run it on Linux or macOS, or in WSL; "
            "`labrun rehearse FILE --fail ROLE.ACTION:0.05` injects faults here."
        )
    checked = checked_file(file, lab, None, param)
    assert checked.lab is not None
    if not checked.lab.lab.simulated:
        fail(
            f"{checked.lab.lab.name} is not a simulated lab: torture kills devices in mid-action. "
            "Leave out --lab, or name a lab with `simulated: true`."
        )
    given = pairs(param, "-p")
    options = [part for name, value in given.items() for part in ("-p", f"{name}={value}")]
    raise typer.Exit(_torture(checked, options, runs, kills, seed, wires=wires, keep=keep))


def _torture(
    checked: Checked, options: list[str], runs: Path, kills: int | None, seed: int, *,
    wires: bool, keep: bool,
) -> int:  # fmt: skip
    from ..run.folder import FolderFault, new_run_folder
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
        say("stopped: the table shows the finished runs")
    except NothingToTorture as fault:
        say(str(fault))
        shutil.rmtree(folder, ignore_errors=True)
        return FAILED
    _tell(plan.report)
    if plan.report.breaches:
        typer.echo(f"The folders of these runs are kept in {folder}.")
    elif not keep:
        shutil.rmtree(folder, ignore_errors=True)
    return FAILED if plan.report.breaches else 0


def _simulate(seeds: range, checked: Checked | None) -> int:
    try:
        from ..simulation.simulate import simulate
    except ImportError as fault:
        say(f"{fault}: the simulated disks need apsw, a part of `pip install 'labrun[test]'`")
        return PROBLEMS
    report = simulate(seeds, checked, say)
    typer.echo(report.table())
    for outcome in report.broken[:SHOWN]:
        file = "" if checked is None or checked.source is None else f" {checked.source.path}"
        typer.echo(f"broken: labrun torture{file} --simulate 1 --seed {outcome.seed}")
        for breach in outcome.breaches[:ALIKE]:
            typer.echo(f"  {breach}")
        if len(seeds) == 1:
            typer.echo("\n".join(outcome.story))
    return FAILED if report.broken else 0


def _tell(report: "Report") -> None:
    typer.echo(report.table())
    shown = first_of_each(report.breaches)[:SHOWN]
    for breach in shown:
        typer.echo(f"broken: {breach.run}: {breach.text}")
    if len(report.breaches) > len(shown):
        typer.echo(f"and {len(report.breaches) - len(shown)} more")


def first_of_each(breaches: "list[Breach]") -> "list[Breach]":
    """The first few of each run and each line of the promise."""
    seen: Counter[tuple[str, str]] = Counter()
    shown = []
    for breach in breaches:
        seen[breach.run, breach.promise] += 1
        if seen[breach.run, breach.promise] <= ALIKE:
            shown.append(breach)
    return shown
