"""`labrun resume RUN`: continue after a stop or a crash, at the first unfinished action."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..check import Checked
from ..exit_status import PROBLEMS
from ..problems.print import print_problems
from .options import RUNS, Params, Runs, fail, failing_on, pairs, run_folder, say
from .run import Answers, Json, Yes, run_to_end, watcher

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...schemas import journal as j
    from ..journal.history import History
    from ..journal.journal import Journal

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
Holes = Annotated[
    bool,
    typer.Option("--holes", help="Measure every point that failed again, in a new pass."),
]
Points = Annotated[
    list[str] | None,
    typer.Option("--point", metavar="KEY", help="Of the holes only this point; may be repeated."),
]
By = Annotated[
    str, typer.Option("--by", metavar="NAME", help="Who asks for it. Default: your user name.")
]


def resume(
    run: RunName,
    changed: Changed = None,
    holes: Holes = False,
    point: Points = None,
    by: By = "",
    param: Params = None,
    runs: Runs = RUNS,
    yes: Yes = False,
    answer: Answers = None,
    json: Json = False,
) -> None:
    """Resume a run from its own folder: finished actions are not done again, except in `--holes`."""
    from ...system.process import user_name
    from ..journal.holes import UnknownHole
    from ..journal.journal import JournalFault
    from ..run.folder import FolderFault, FolderLock

    answers, params = pairs(answer, "--answer"), pairs(param, "-p")
    by = by or user_name()
    again = (point or []) if holes or point else None
    try:
        with failing_on(FolderFault, JournalFault, UnknownHole):
            folder = run_folder(runs, run)
            lock = FolderLock(folder)
            lock.take()
            try:
                raise typer.Exit(
                    _go_on(
                        folder, changed, params, again, by=by, yes=yes, answers=answers, json=json
                    )
                )
            finally:
                lock.release()
    except OSError as fault:
        fail(f"cannot resume {run}: {fault.filename}: {fault.strerror}. Nothing was sent.")


def _go_on(
    folder: Path,
    changed: Path | None,
    params: dict[str, str],
    again: list[str] | None,
    *,
    by: str,
    yes: bool,
    answers: dict[str, str],
    json: bool,
) -> int:
    from ..journal.history import read_history
    from ..journal.holes import redo
    from ..journal.journal import Records, reopen
    from ..run.folder import check_hashes, newest_copies
    from ..runner.begin import RunOptions, old_run
    from ..runner.change import check_copy, keep_change
    from ..runner.runner import run_session

    records = Records(folder / "journal.jsonl")
    history = read_history(records)
    anew = changed is not None or bool(params)
    wanted = redo(records, again, by=by) if again is not None else None
    if not anew and wanted is None and (over := _why_over(folder.name, history)):
        say(over)
        return PROBLEMS
    place = newest_copies(folder, history)
    check_hashes(folder, history)
    checked, given = check_copy(place, changed, params)
    if not checked.ok:
        print_problems(checked.problems, format="text", file=sys.stderr)
        return PROBLEMS
    reopened = hold_against(checked, list(records), yes=yes) if anew else []
    if reopened is None:
        return PROBLEMS
    journal, records, torn = reopen(folder / "journal.jsonl")
    if torn:
        say(f"the journal's last record was incomplete ({torn} bytes) and was cut off")
    if anew:
        journal.append(keep_change(folder, checked, given, len(history.changes), reopened))
        journal.flush()
    if wanted is not None:
        _note(journal, wanted)
    history = read_history(records)
    options = RunOptions(
        yes=yes, by=by, answers=answers, watchers=[watcher(json)], live_figures=True, say=say
    )
    the_run = old_run(folder, checked, options, journal, history, torn)
    return run_to_end(run_session(the_run, checked, options, records))


def _why_over(run: str, history: "History") -> str:
    """Why there is nothing to resume, and what can be done instead; empty if there is."""
    if history.finished is None:
        return ""
    again = f"`labrun resume {run} --holes` measures its {_holes(history.hole_count)} again"
    if history.finished.fate == "succeeded":
        return (
            f"{run} has already succeeded: there is nothing to resume. "
            + (f"{again}; " if history.hole_count else "")
            + "`labrun report` makes its report again; `labrun resume --changed FILE` adds to it."
        )
    if history.is_through:
        return f"{run} is through, and no point succeeded: there is nothing to resume. {again}."
    return ""


def _note(journal: "Journal", wanted: "j.Redo") -> None:
    """On disk before anything of it is done."""
    journal.append(wanted)
    journal.flush()
    number = len(wanted.iterations)
    say(f"{_holes(number)} will be measured again (pass {wanted.pass_number}, {wanted.by})")


def _holes(number: int) -> str:
    return f"{number:,} hole{'s' if number != 1 else ''}"


def hold_against(
    checked: Checked, records: "Sequence[j.JournalRecord]", *, yes: bool
) -> list[str] | None:
    """Show the differences; returns the iterations to reopen, or None if the run cannot go on so."""
    from ..runner.change import differences, why_not
    from ..runner.compare import compare

    found = compare(checked, records)
    for line in differences(found):
        say(line)
    if why := why_not(found, yes=yes):
        say(why)
        return None
    return found.reopened
