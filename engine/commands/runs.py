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
        typer.echo(f"{line['run']:<44} {line['fate']:<12} {_more(line)}".rstrip())


def _more(line: dict[str, Any]) -> str:
    done = f"{line['done']} iterations" if line["done"] else ""
    return ", ".join(part for part in (done, line["reason"]) if part)


def row(folder: Path) -> dict[str, Any]:
    """One run as a row; its fate is `interrupted` if its engine vanished without recording an end."""
    from ..journal.history import read_history
    from ..journal.journal import JournalFault, read_records
    from ..run.folder import is_live

    row = {"run": folder.name, "protocol": "", "fate": "", "reason": "", "done": 0}
    try:
        history = read_history(list(read_records(folder / "journal.jsonl")))
    except JournalFault as fault:
        return {**row, "fate": "unreadable", "reason": str(fault)}
    done = sum(len(fates) for fates in history.past.iterations.values())
    protocol = history.started.protocol if history.started else ""
    row.update(protocol=protocol, done=done)
    if is_live(folder):
        return {**row, "fate": "running"}
    if history.finished is None:
        reason = f"continue with `labrun resume {folder.name}`"
        return {**row, "fate": "interrupted", "reason": reason}
    return {**row, "fate": history.finished.fate, "reason": history.finished.reason}
