"""`labrun run FILE`: check, start, show progress, leave a run folder."""

import asyncio
import errno
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...system.output import unhurried_stdout
from ...system.page import why_no_page
from ..check import Checked
from ..exit_status import CTRL_C, FAILED, NOT_REACHED, SUCCEEDED
from .checked_protocol import checked_file, fitting_answers
from .options import RUNS, Bind, File, Lab, Params, Runs, fail, pairs, say

if TYPE_CHECKING:
    from ..run.folder import FolderLock
    from ..run.run import Run
    from ..runner.begin import RunOptions

Yes = Annotated[bool, typer.Option("--yes", "-y", help="Answer every `confirm` with yes.")]
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
Answers = Annotated[
    list[str] | None,
    typer.Option("--answer", metavar="ID=CHOICE", help="Answer a question in advance."),
]
Wait = Annotated[
    bool, typer.Option("--wait", help="Wait for devices that another run holds, then begin.")
]
AtMost = Annotated[
    str, typer.Option("--at-most", metavar="TIME", help="How long to --wait, such as 8 h.")
]
Json = Annotated[bool, typer.Option("--json", help="Report events as lines of JSON.")]


def run(
    file: File,
    param: Params = None,
    lab: Lab = None,
    bind: Bind = None,
    runs: Runs = RUNS,
    yes: Yes = False,
    answer: Answers = None,
    wait: Wait = False,
    at_most: AtMost = "24 h",
    json: Json = False,
) -> None:
    """Check a protocol, run it, and leave a folder with everything that happened."""
    wait_s = waiting_s(at_most) if wait else 0.0
    checked = checked_file(file, lab, bind, param, json=json)
    answers = fitting_answers(answer, checked)
    given = pairs(param, "-p")
    raise typer.Exit(
        start(checked, runs, given=given, yes=yes, answers=answers, json=json, wait_s=wait_s)
    )


def waiting_s(at_most: str) -> float:
    """The longest wait in seconds; ends the command for anything that is no time."""
    from ...schemas.quantity import UnitError, seconds

    try:
        return seconds(at_most)
    except UnitError:
        fail(f"--at-most {at_most}: write a time, such as --at-most '8 h'")


def start(
    checked: Checked,
    runs: Path,
    *,
    given: dict[str, str] | None = None,
    yes: bool = False,
    answers: dict[str, str] | None = None,
    json: bool = False,
    wait_s: float = 0.0,
) -> int:
    """Make the run's folder and run the protocol; returns the exit status."""
    from ..journal.journal import JournalFault
    from ..run.folder import FolderFault
    from ..runner.begin import RunOptions
    from ..runner.runner import run_session

    options = RunOptions(
        yes=yes, answers=answers or {}, watchers=[watcher(json)], live_figures=True, say=say,
        wait_s=wait_s,
    )  # fmt: skip
    try:
        the_run, lock = begin(checked, runs, given or {}, options)
    except (FolderFault, JournalFault) as fault:
        say(str(fault))
        return FAILED
    try:
        return run_to_end(run_session(the_run, checked, options))
    finally:
        lock.release()


def begin(
    checked: Checked, runs: Path, given: dict[str, str], options: "RunOptions"
) -> "tuple[Run, FolderLock]":
    """A new run, and the lock on its folder, which whoever runs it releases.

    Raises FolderFault or JournalFault, and then leaves no folder.
    """
    from ..run.folder import FolderFault, FolderLock, new_run_folder
    from ..runner.begin import keep, new_run

    assert checked.protocol is not None
    folder = new_run_folder(runs, checked.protocol.name)
    lock = FolderLock(folder)
    try:
        keep(folder, checked, given)
        lock.take()
        return new_run(folder, checked, options), lock
    except BaseException as fault:  # Ctrl-C as well
        lock.release()
        shutil.rmtree(folder, ignore_errors=True)
        if isinstance(fault, OSError):
            raise FolderFault(f"cannot begin {folder}: {fault.strerror or fault}") from fault
        raise


def run_to_end(session) -> int:
    """Run one engine session; returns its ending as an exit status."""
    from ..dispatch.connect import NotReached
    from ..journal.journal import JournalFault

    try:
        with unhurried_stdout():
            ending = asyncio.run(session)
    except (JournalFault, NotReached, OSError) as fault:
        say(in_words(fault))
        return NOT_REACHED if isinstance(fault, NotReached) else FAILED
    if why := why_no_page():
        say(f"the page, `labrun web`, is missing here: {why}. See docs/how-to/web.md")
    if ending.interrupted:
        return CTRL_C
    return SUCCEEDED if ending.fate == "succeeded" else FAILED


def in_words(fault: Exception) -> str:
    """What ended an engine session before its own end, and what now."""
    from ..journal.journal import NotWritten

    if not isinstance(fault, OSError | NotWritten):
        return f"{fault}. Nothing was sent."
    said, cured = str(fault), "that is cured"
    if isinstance(fault, OSError):
        said = f"{fault.strerror or fault}: {fault.filename or 'the folder of the run'}"
        cured = "there is space again" if fault.errno in FULL else cured
    return f"{said}. Devices are safe. When {cured}, `labrun resume last` continues the run."


def watcher(json: bool):
    """How progress is shown here: JSON lines, a live display, or plain lines."""

    def watch(run, control):
        if json:
            from ..progress.json_lines import JsonWatch

            return JsonWatch()
        if sys.stdout.isatty() and sys.stdin.isatty():
            from ..progress.rich_terminal import RichWatch

            return RichWatch(run, control)
        from ..progress.plain import PlainWatch

        return PlainWatch()

    return watch
