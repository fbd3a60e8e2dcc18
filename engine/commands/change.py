"""`labrun change RUN FILE`: a live run goes on with another protocol, between two actions."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import FAILED, PROBLEMS
from .options import RUNS, Params, Runs, fail, failing_on, pairs, run_folder, say
from .resume import By, RunName, hold_against

File = Annotated[
    Path | None, typer.Argument(help="The changed protocol. Without it only parameters change.")
]
Yes = Annotated[
    bool,
    typer.Option(
        "--yes", "-y", help="Change it without a question, and keep work that is in doubt."
    ),
]


def change(
    run: RunName, file: File = None, param: Params = None, runs: Runs = RUNS, yes: Yes = False,
    by: By = "",
) -> None:  # fmt: skip
    """Show what a changed protocol would mean for a live run, ask, and change it between two actions."""
    from ...system.process import user_name
    from ..control.server import NotLive, ask_run
    from ..journal.journal import JournalFault
    from ..run.folder import FolderFault

    params, folder = pairs(param, "-p"), run_folder(runs, run)
    with failing_on(FolderFault, JournalFault):
        _show(folder, file, params, yes=yes)
    if not yes and not _agrees():
        say("nothing was changed; add --yes to change it")
        return
    say("the run comes to rest between two actions; `labrun continue` withdraws the change")
    request = {
        "verb": "change", "file": str(file.resolve()) if file is not None else None,
        "params": params, "yes": yes, "by": by or user_name(),
    }  # fmt: skip
    try:
        ok, text = ask_run(folder, request, timeout_s=None)
    except NotLive:
        fail(
            f"{folder.name} has ended meanwhile; `labrun resume` continues it as its journal says",
            FAILED,
        )
    if not ok:
        fail(text)
    typer.echo(text)


def _show(folder: Path, file: Path | None, params: dict[str, str], *, yes: bool) -> None:
    from ..journal.history import read_history
    from ..journal.journal import Records
    from ..problems.print import print_problems
    from ..run.folder import is_live, newest_copies
    from ..runner.change import check_copy

    if not is_live(folder):
        fail(
            f"{folder.name} is not running; `labrun resume {folder.name} --changed FILE` changes it",
            FAILED,
        )
    if file is None and not params:
        fail("give the changed protocol, or a parameter with -p NAME=VALUE")
    records = list(Records(folder / "journal.jsonl"))
    checked, _ = check_copy(newest_copies(folder, read_history(records)), file, params)
    if not checked.ok:
        print_problems(checked.problems, format="text", file=sys.stderr)
        raise typer.Exit(PROBLEMS)
    if hold_against(checked, records, yes=yes) is None:
        raise typer.Exit(PROBLEMS)


def _agrees() -> bool:
    return sys.stdin.isatty() and typer.confirm("Change the run so?", err=True)
