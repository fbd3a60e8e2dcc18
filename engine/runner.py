"""The life of a run from outside: connect, live, end, report; signals abort it."""

import asyncio
import contextlib
import shutil
import signal

from ..schemas import journal as j
from .begin import Wishes
from .check import Checked
from .connect import connect
from .control import Control
from .control_server import ControlServer
from .encode import encode
from .journal import DiskFull, JournalFault
from .life import Ending, Life
from .live_figures import live_figures
from .reports import make_reports
from .run import Run
from .run_files import sync_files
from .run_folder import CONTRACTS, COPIES


async def run_life(
    run: Run, checked: Checked, wishes: Wishes, records: list[j.JournalRecord] | None = None
) -> Ending:
    """Connect, live, and end a run; raises NotReached before anything was sent.

    A new run whose devices cannot be reached leaves no folder behind.
    """
    assert checked.lab is not None
    loop = asyncio.get_running_loop()
    try:
        connections = await connect(checked.roles, checked.lab, run.folder, run.id)
    except BaseException:
        with contextlib.suppress(JournalFault, DiskFull):
            run.journal.close()
        if records is None:
            shutil.rmtree(run.folder, ignore_errors=True)
        raise
    life = Life(run, checked, connections.clients)
    connections.say = run.log
    run.questions.changed = life.dispatcher.wake.set
    endpoint = ControlServer(run.folder, life.control, run.questions)
    with _signals(loop, life.control):
        try:
            await endpoint.open()
            run.listeners.append(endpoint.publish)
            for watcher in wishes.watchers:
                run.listeners.append(watcher(run, life.control))
            # From here on the run's name is known to a person, and so the run must last.
            run.journal.flush()
            sync_files(run.folder, CONTRACTS, COPIES)
            run.tell("run", run.id, "running", checked.protocol.name if checked.protocol else "")
            async with live_figures(run, wishes.live_figures):
                ending = await life.live(records)
            await _end(run, life, ending)
            return ending
        finally:
            await endpoint.close()
            await connections.close()


async def _end(run: Run, life: Life, ending: Ending) -> None:
    """The last record, then the reports: they read what the journal says."""
    outputs = life.outputs() if ending.fate == "succeeded" else {}
    try:
        run.record(
            j.Finished(
                fate=ending.fate, reason=ending.reason, holes=run.holes, outputs=encode(outputs)
            )
        )
        run.journal.close()
    except (JournalFault, DiskFull) as fault:
        ending.reason = (
            f"{ending.reason}; {fault}" if str(fault) not in ending.reason else ending.reason
        )
    made, failed = await asyncio.to_thread(make_reports, run.folder)
    for path in made:
        run.tell("report", text=str(path))
    for line in failed:
        run.log(line)
    run.tell(
        "finished", run.id, ending.fate, ending.reason, holes=run.holes, outputs=encode(outputs),
        folder=str(run.folder),
    )  # fmt: skip


@contextlib.contextmanager
def _signals(loop: asyncio.AbstractEventLoop, control: Control):
    """Ctrl-C, SIGTERM and SIGHUP abort the run while it lives."""
    names = {"SIGINT": "Ctrl-C", "SIGTERM": "SIGTERM", "SIGHUP": "SIGHUP"}
    taken: list[int] = []
    for name, by in names.items():
        number = getattr(signal, name, None)
        if number is None:
            continue
        with contextlib.suppress(NotImplementedError, RuntimeError, ValueError):
            loop.add_signal_handler(number, control.ask, "abort", by)
            taken.append(number)
    try:
        yield
    finally:
        for number in taken:
            loop.remove_signal_handler(number)
