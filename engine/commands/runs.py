"""`labrun runs`: what was run, when, and how it ended."""

import json as jsonlib
from pathlib import Path
from typing import Annotated, Any

import typer

from .options import RUNS, Runs

Json = Annotated[bool, typer.Option("--json", help="Print a JSON list of objects.")]


def runs(runs: Runs = RUNS, json: Json = False) -> None:
    """List the runs, oldest first."""
    from ..run.folder import all_runs

    rows = [row(folder) for folder in all_runs(runs)]
    if json:
        typer.echo(jsonlib.dumps(rows, indent=1))
        return
    if not rows:
        typer.echo(f"no runs in {runs}")
    for line in rows:
        typer.echo(f"{line['run']:<44} {line['word']:<12} {_more(line)}".rstrip())


def _more(line: dict[str, Any]) -> str:
    return ", ".join(part for part in (line["points"], line["reason"]) if part)


def row(folder: Path) -> dict[str, Any]:
    """One run as a row; its fate is `interrupted` if its engine vanished without recording an end."""
    from ...schemas.journal import ended_as
    from ..journal.journal import JournalFault
    from ..run.summary import summary_of

    try:
        told = summary_of(folder)
    except JournalFault as fault:
        unknown = {"plan": None, "measured": 0, "failed": 0, "left": None}
        told = {"run": folder.name, "protocol": "", "fate": "unreadable", "reason": str(fault)}
        return {**told, "word": "unreadable", "done": 0, "holes": 0, "points": "", **unknown}
    reason = told.reason
    if told.fate == "interrupted":
        reason = f"continue with `labrun resume {folder.name}`"
    points = told.points
    return {
        "run": folder.name, "protocol": told.protocol, "fate": told.fate, "reason": reason,
        "word": ended_as(told.fate, told.holes), "done": points.measured + points.failed,
        "holes": told.holes, "points": points.words(told.holes), **points.model_dump(),
    }  # fmt: skip
