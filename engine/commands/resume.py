"""`labrun resume RUN`: go on after a stop or a crash, at the first unfinished action."""

import json as jsonlib
import sys
from pathlib import Path
from typing import Annotated

import typer

from ..check import Checked, check_file
from ..exit_status import PROBLEMS
from ..print_problems import print_problems
from .options import RUNS, Runs, WrongUsage, pairs, say
from .run import Answers, Json, Yes, live, watcher

RunName = Annotated[
    str,
    typer.Argument(metavar="RUN", help="A run's folder, its name, its last letters, or `last`."),
]


def resume(
    run: RunName, runs: Runs = RUNS, yes: Yes = False, answer: Answers = None, json: Json = False
) -> None:
    """Go on with a run from its own folder: finished actions are not done again."""
    from ..journal import JournalFault
    from ..run_folder import FolderFault, FolderLock, find_run

    try:
        answers = pairs(answer, "--answer")
        folder = find_run(runs, run)
        lock = FolderLock(folder)
        lock.take()
        try:
            raise typer.Exit(_go_on(folder, yes=yes, answers=answers, json=json))
        finally:
            lock.release()
    except (FolderFault, JournalFault, WrongUsage) as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None


def _go_on(folder: Path, *, yes: bool, answers: dict[str, str], json: bool) -> int:
    from ..history import read_history
    from ..journal import reopen
    from ..runner import Wishes, old_run, run_life

    journal, records, torn = reopen(folder / "journal.jsonl")
    history = read_history(records)
    if history.finished is not None and history.finished.fate == "succeeded":
        journal.close()
        say(f"{folder.name} has succeeded already: there is nothing to go on with")
        return PROBLEMS
    checked = check_copy(folder)
    if not checked.ok:
        journal.close()
        print_problems(checked.problems, format="text", file=sys.stderr)
        return PROBLEMS
    if torn:
        say(f"the journal's last record was torn ({torn} bytes) and was cut off")
    wishes = Wishes(yes=yes, answers=answers, watchers=[watcher(json)])
    run = old_run(folder, checked, wishes, journal, history, torn)
    return live(run_life(run, checked, wishes, records))


def check_copy(folder: Path) -> Checked:
    """Check the run's own copies, with its parameters and devices, as at its start."""
    from ..run_folder import ASKED, LAB, FolderFault, protocol_file

    try:
        asked = jsonlib.loads((folder / ASKED).read_text(encoding="utf-8"))
    except (OSError, ValueError) as fault:
        raise FolderFault(f"{folder / ASKED} cannot be read: {fault}") from fault
    return check_file(
        protocol_file(folder), lab=folder / LAB, bind=asked["roles"], params=asked["params"]
    )
