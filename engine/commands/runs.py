"""`labrun runs`: what was run, when, and how it ended."""

import json as jsonlib
from pathlib import Path
from typing import Annotated, Any

import typer

from .options import RUNS, Runs

Json = Annotated[bool, typer.Option("--json", help="A list of objects, for programs.")]


def runs(runs: Runs = RUNS, json: Json = False) -> None:
    """List the runs, oldest first."""
    from ..run_folder import all_runs

    rows = [row(folder) for folder in all_runs(runs)]
    if json:
        typer.echo(jsonlib.dumps(rows, indent=1))
        return
    if not rows:
        typer.echo(f"no runs in {runs}")
    for line in rows:
        typer.echo(f"{line['run']:<44} {line['fate']:<12} {_more(line)}".rstrip())


def _more(line: dict[str, Any]) -> str:
    done = f"{line['done']} iterations" if line["done"] else ""
    return ", ".join(part for part in (done, line["reason"]) if part)


def row(folder: Path) -> dict[str, Any]:
    """One run in a line: its fate is `interrupted` where its engine went without a last word."""
    from ..history import read_history
    from ..journal import JournalFault, read_records
    from ..run_folder import is_live

    told = {"run": folder.name, "protocol": "", "fate": "", "reason": "", "done": 0}
    try:
        history = read_history(list(read_records(folder / "journal.jsonl")))
    except JournalFault as fault:
        return {**told, "fate": "unreadable", "reason": str(fault)}
    done = sum(counts.total for counts in history.counts.values())
    protocol = history.started.protocol if history.started else ""
    told.update(protocol=protocol, done=done)
    if is_live(folder):
        return {**told, "fate": "running"}
    if history.finished is None:
        reason = f"go on with `labrun resume {folder.name}`"
        return {**told, "fate": "interrupted", "reason": reason}
    return {**told, "fate": history.finished.fate, "reason": history.finished.reason}
