"""`labrun runs`: what was run, when, and how it ended; found again by words, values, days."""

import json as jsonlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import RUNS, Runs, fail

if TYPE_CHECKING:
    from ..index.entry import Entry

Find = Annotated[
    str,
    typer.Option(
        "--find",
        metavar="TEXT",
        help='Which: "core sample:K17 pitch<0.2mm outcome:failed since:7d -tag:bad".',
    ),
]
Value = Annotated[
    str,
    typer.Option(
        "--value", metavar="NAME", help="An output, parameter or TABLE.COLUMN over these runs."
    ),
]
Low = Annotated[
    str, typer.Option("--low", metavar="QUANTITY", help="A lower limit of your own for --value.")
]
High = Annotated[
    str, typer.Option("--high", metavar="QUANTITY", help="An upper limit of your own for --value.")
]
Json = Annotated[bool, typer.Option("--json", help="Print a JSON list of objects.")]


def runs(
    runs: Runs = RUNS, find: Find = "", value: Value = "", low: Low = "", high: High = "",
    json: Json = False,
) -> None:  # fmt: skip
    """List the runs, oldest first."""
    from ..index.index import find_runs
    from ..index.wanted import NotUnderstood

    try:
        entries = find_runs(runs, find)
    except NotUnderstood as fault:
        fail(f"--find {fault}")
    if value:
        _over_runs(entries, value, low, high, json)
    elif low or high:
        fail("--low and --high are limits of a --value: name it, such as --value data.Li")
    elif json:
        typer.echo(jsonlib.dumps([row(entry, runs) for entry in entries], indent=1))
    else:
        if not entries:
            typer.echo(f"no runs in {runs}{f' for {find}' if find else ''}")
        print_runs(entries, runs)


def print_runs(entries: "list[Entry]", runs: Path) -> None:
    """A line for each run: its name, how it ended, how far it came."""
    width = max([12, *(len(entry.word) for entry in entries)])
    for entry in entries:
        line = row(entry, runs)
        typer.echo(f"{line['run']:<44} {line['word']:<{width}}  {_more(line)}".rstrip())


def _more(line: dict[str, Any]) -> str:
    but = "but " if line["fate"] == "succeeded" and line["reason"] else ""
    told = [", ".join(line["samples"][:3]), line["points"], but + line["reason"], *line["tags"]]
    return ", ".join(part for part in told if part)


def row(entry: "Entry", runs: Path) -> dict[str, Any]:
    """One run as a row; its fate is `interrupted` if its engine vanished without recording an end."""
    from ..journal.journal import JournalFault
    from ..run.summary import summary_of

    points = entry.points
    if entry.fate == "running":  # the index does not follow a journal that grows
        try:
            points = summary_of(runs / entry.run).points
        except (JournalFault, OSError):
            points = entry.points
    return {
        "run": entry.run, "protocol": entry.protocol, "fate": entry.fate, "reason": entry.reason,
        "word": entry.word, "began": entry.began, "person": entry.person,
        "samples": entry.samples.splitlines(), "tags": entry.tags.splitlines(), "note": entry.note,
        "done": points.measured + points.failed,
        "holes": entry.holes, "points": points.words(entry.holes), **points.model_dump(),
    }  # fmt: skip


def _over_runs(entries: "list[Entry]", name: str, low: str, high: str, json: bool) -> None:
    """A number over runs, with its limits."""
    from ..index.control_chart import chart, none_has
    from ..index.wanted import NotUnderstood

    try:
        made = chart(entries, name, low, high)
    except NotUnderstood as fault:
        fail(f"--{fault}")
    if not made.points:
        fail(f"--value {name}: {none_has(entries, name)}")
    if json:
        rows = [
            {"run": entry.run, "began": entry.began, "value": number, "out": made.is_out(number)}
            for entry, number in made.points
        ]
        limits = {"low": made.low, "mean": made.mean, "high": made.high}
        told = {"name": name, "unit": made.unit, **limits, "runs": rows}
        typer.echo(jsonlib.dumps(told, indent=1))
        return
    for entry, number in made.points:
        out = "  outside of the limits" if made.is_out(number) else ""
        typer.echo(f"{entry.run:<44} {number:>14.6g} {made.unit}{out}".rstrip())
    limits = [
        f"{word} {limit:.6g} {made.unit}".rstrip()
        for word, limit in (("mean", made.mean), ("low", made.low), ("high", made.high))
        if limit is not None
    ]
    out = sum(made.is_out(number) for _, number in made.points)
    if limits:
        typer.echo(f"{', '.join(limits)}: {out} of {len(made.points)} outside")
