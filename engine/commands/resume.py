"""`labrun resume RUN`: continue after a stop or a crash, at the first unfinished action."""

import json as jsonlib
import sys
from pathlib import Path
from typing import Annotated

import typer

from ..check import Checked, check_file
from ..exit_status import PROBLEMS
from ..problems.print import print_problems
from .options import RUNS, Params, Runs, WrongUsage, pairs, say
from .run import Answers, Json, Yes, run_to_end, watcher

RunName = Annotated[
    str,
    typer.Argument(metavar="RUN", help="A run's folder, its name, the end of its name, or `last`."),
]
Changed = Annotated[
    Path | None,
    typer.Option(
        "--changed",
        metavar="FILE",
        help="Resume with this protocol where finished work still fits.",
    ),
]


def resume(
    run: RunName,
    changed: Changed = None,
    param: Params = None,
    runs: Runs = RUNS,
    yes: Yes = False,
    answer: Answers = None,
    json: Json = False,
) -> None:
    """Resume a run from its own folder: finished actions are not done again."""
    from ..journal.journal import JournalFault
    from ..run.folder import FolderFault, FolderLock, find_run

    try:
        answers, params = pairs(answer, "--answer"), pairs(param, "-p")
        folder = find_run(runs, run)
        lock = FolderLock(folder)
        lock.take()
        try:
            raise typer.Exit(_go_on(folder, changed, params, yes=yes, answers=answers, json=json))
        finally:
            lock.release()
    except (FolderFault, JournalFault, WrongUsage) as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None


def _go_on(
    folder: Path,
    changed: Path | None,
    params: dict[str, str],
    *,
    yes: bool,
    answers: dict[str, str],
    json: bool,
) -> int:
    from ..journal.history import read_history
    from ..journal.journal import Records, reopen
    from ..run.folder import check_hashes, newest_copies
    from ..runner.begin import RunOptions, old_run
    from ..runner.runner import run_session
    from .changed_protocol import hold_against, keep_change

    records = Records(folder / "journal.jsonl")
    history = read_history(records)
    anew = changed is not None or bool(params)
    if history.finished is not None and history.finished.fate == "succeeded" and not anew:
        say(
            f"{folder.name} has already succeeded: there is nothing to resume. "
            "`labrun report` makes its report again; `labrun resume --changed FILE` adds to it."
        )
        return PROBLEMS
    place = newest_copies(folder, history)
    check_hashes(folder, history)
    checked, given = check_copy(place, changed, params)
    if not checked.ok:
        print_problems(checked.problems, format="text", file=sys.stderr)
        return PROBLEMS
    reopened = hold_against(folder, checked, list(records), yes=yes) if anew else []
    if reopened is None:
        return PROBLEMS
    journal, records, torn = reopen(folder / "journal.jsonl")
    if torn:
        say(f"the journal's last record was incomplete ({torn} bytes) and was cut off")
    if anew:
        keep_change(folder, checked, given, journal, len(history.changes), reopened)
        history = read_history(records)
    options = RunOptions(
        yes=yes, answers=answers, watchers=[watcher(json)], live_figures=True, say=say
    )
    the_run = old_run(folder, checked, options, journal, history, torn)
    return run_to_end(run_session(the_run, checked, options, records))


def check_copy(
    place: Path, changed: Path | None = None, params: dict[str, str] | None = None
) -> tuple[Checked, dict[str, str]]:
    """Check the run's own copies, or a changed protocol instead; and the parameters given."""
    from ..run.folder import ASKED, LAB, FolderFault, protocol_file

    try:
        asked = jsonlib.loads((place / ASKED).read_text(encoding="utf-8"))
    except (OSError, ValueError) as fault:
        raise FolderFault(f"{place / ASKED} cannot be read: {fault}") from fault
    given = {**asked["params"], **(params or {})}
    checked = check_file(
        changed or protocol_file(place), lab=place / LAB, bind=asked["roles"], params=given
    )
    return checked, given
