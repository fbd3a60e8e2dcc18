"""`labrun rehearse FILE`: hours of a protocol in seconds, with injected faults."""

import json as jsonlib
import sys
from collections.abc import Callable
from typing import Annotated, Any

import typer

from ...schemas.quantity import UnitError, seconds
from ...system.output import read_or_not
from ..check import Checked
from ..exit_status import FAILED, SUCCEEDED
from ..journal.gantt import Gantt
from .checked_protocol import checked_file
from .options import Bind, File, Lab, Params, WrongUsage, failing_on

Fail = Annotated[
    list[str] | None,
    typer.Option(
        "--fail",
        metavar="ROLE.ACTION[.ERROR][:CHANCE]",
        help="Make an action fail, with this probability or always: --fail libs.measure:0.05",
    ),
]
Seed = Annotated[int | None, typer.Option("--seed", help="Seed for the injected faults.")]
Turns = Annotated[
    int, typer.Option("--turns", min=1, help="The most turns of a `while` without `max`.")
]
From = Annotated[
    str, typer.Option("--from", metavar="TIME", help="The chart of what runs when begins then.")
]
To = Annotated[
    str,
    typer.Option("--to", metavar="TIME", help="And ends then: --to '10 min' for a closer look."),
]
Json = Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")]


def rehearse(
    file: File,
    param: Params = None,
    lab: Lab = None,
    bind: Bind = None,
    fail: Fail = None,
    seed: Seed = None,
    turns: Turns = 10_000,
    from_: From = "0 s",
    to: To = "",
    json: Json = False,
) -> None:
    """Play the whole protocol on simulated devices and a virtual clock: how long, how far, what fails."""
    checked = checked_file(file, lab, bind, param, json=json)
    raise typer.Exit(_rehearse(checked, fail or [], seed, turns, (from_, to), json=json))


def _rehearse(
    checked: Checked, fail: list[str], seed: int | None, turns: int, part: tuple[str, str],
    *, json: bool,
) -> int:  # fmt: skip
    from ..rehearse.rehearse import NoRehearsal, Rehearsal
    from ..rehearse.table import lines

    with failing_on(NoRehearsal, WrongUsage):
        faults, shown = ordered(fail, checked), looked_at(*part)
        rehearsal = Rehearsal(checked, faults, seed, turns, _progress(json=json), shown)
        totals = rehearsal.play()
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr)
    with read_or_not():
        if json:
            typer.echo(jsonlib.dumps(totals.as_dict(), indent=1))
        else:
            for line in lines(totals, rehearsal.real_s):
                typer.echo(line)
    return SUCCEEDED if totals.fate == "succeeded" else FAILED


def _progress(*, json: bool) -> Callable[[float, int], None]:
    """A progress line at a terminal; nothing elsewhere."""
    from ..rehearse.table import duration

    if json or not sys.stderr.isatty():
        return lambda at_s, goals: None

    def show(at_s: float, goals: int) -> None:
        if goals % 50 == 0:
            print(
                f"\rrehearsing: {duration(at_s)}, {goals:,} goals \033[K", end="", file=sys.stderr
            )

    return show


def looked_at(from_: str, to: str) -> Gantt:
    """The part of the time that the chart shows; raises WrongUsage with a sentence."""
    try:
        from_s, to_s = seconds(from_), seconds(to) if to else None
    except UnitError:
        given = f"--from {from_}" + (f" --to {to}" if to else "")
        raise WrongUsage(f"{given}: write times, such as --to '10 min'") from None
    if to_s is not None and from_s >= to_s:
        raise WrongUsage(f"--from {from_} is not before --to {to}")
    return Gantt(from_s, to_s)


def ordered(fail: list[str], checked: Checked) -> dict[str, dict[str, Any]]:
    """`libs.measure:0.05` -> faults by device and action; raises WrongUsage with a sentence."""
    faults: dict[str, dict[str, Any]] = {}
    for text in fail:
        name, mark, chance = text.partition(":")
        role, _, rest = name.partition(".")
        action, _, error = rest.partition(".")
        try:
            chance = float(chance if mark else 1)
            if not (action and 0 <= chance <= 1):
                raise ValueError
        except ValueError:
            raise WrongUsage(
                f"--fail {text}: write --fail ROLE.ACTION:CHANCE or ROLE.ACTION.ERROR:CHANCE, "
                "with a chance from 0 to 1; without one it always fails"
            ) from None
        if role not in checked.roles:
            raise WrongUsage(f"--fail {text}: no role {role}; roles: {', '.join(checked.roles)}")
        wanted = faults.setdefault(checked.roles[role].device, {})
        if not error:
            wanted[action] = chance
        elif isinstance(wanted.setdefault(action, {}), dict):
            wanted[action][error] = chance
    return faults
