"""An engine session from outside: connect, run, end, report; signals abort it."""

import asyncio
import contextlib
import shutil
from collections.abc import Iterable

from ...schemas import journal as j
from ...schemas.event import KINDS
from ...system.files import sync_files
from ...system.signals import on_end
from ..check import Checked
from ..control.server import ControlServer
from ..dispatch.connect import connect
from ..journal.encode import encode
from ..journal.journal import DiskFull, JournalFault
from ..run.folder import CONTRACTS, COPIES
from ..run.run import Run
from ..run.summary import keep_summary
from .begin import RunOptions
from .live_figures import live_figures
from .notify import Notifier
from .reports import make_reports
from .session import Ending, RunSession


async def run_session(
    run: Run,
    checked: Checked,
    options: RunOptions,
    records: Iterable[j.JournalRecord] | None = None,
) -> Ending:
    """Connect, run, and end; raises NotReached before anything is sent.

    A new run whose devices cannot be reached leaves no folder behind.
    """
    assert checked.lab is not None
    try:
        connections = await connect(
            checked.roles, checked.lab, run.folder, run.id, run.history.marks, options.say,
            options.wait_s,
        )  # fmt: skip
    except BaseException:  # a cancel as well
        with contextlib.suppress(JournalFault, DiskFull):
            run.journal.close()
        if records is None:
            shutil.rmtree(run.folder, ignore_errors=True)
        raise
    session = RunSession(run, checked, connections.clients)
    connections.say = run.log
    run.questions.changed = session.dispatcher.wake.set
    endpoint = ControlServer(run, session.control, session.change.ask)
    notifier: Notifier | None = None
    deaf = on_end(lambda by: session.control.ask("abort", by))
    try:
        await endpoint.open()
        for make in options.watchers:
            watcher = make(run, session.control)
            run.listen(watcher, getattr(watcher, "kinds", KINDS))
        # From here on the run's name is known to a person, so the run must be durable.
        run.journal.flush()
        sync_files(run.folder, CONTRACTS, COPIES)
        run.tell(
            "run", run.folder.name, "running", checked.protocol.name if checked.protocol else ""
        )
        if checked.lab.lab.notify is not None:
            notifier = Notifier(run, checked.lab.lab.notify)
            run.notify = notifier.send
            run.listen(notifier.hear, ("question", "finished"))
        async with live_figures(run, options.live_figures):
            ending = await session.execute(records)
        # A lease that is not released lapses, and then its server makes the device safe.
        connections.leased = [d for d in connections.leased if d not in session.unsafe]
        await _end(run, session, ending)
        return ending
    finally:
        if notifier is not None:
            await notifier.close()
        await endpoint.close()
        await connections.close()
        deaf()


async def _end(run: Run, session: RunSession, ending: Ending) -> None:
    """Write the last record, then the reports, which read the journal."""
    outputs = session.outputs() if ending.fate == "succeeded" else {}
    run.history.end(ending.fate, ending.detail)
    try:
        run.record(
            j.Finished(
                fate=ending.fate,
                reason=ending.reason,
                detail=ending.detail,
                holes=run.history.hole_count,
                points=run.history.points(),
                outputs=encode(outputs),
            )
        )
        run.journal.close()
        keep_summary(run.folder, run.history)
    except (JournalFault, DiskFull) as fault:
        ending.reason = (
            f"{ending.reason}; {fault}" if str(fault) not in ending.reason else ending.reason
        )
    made, failed = await asyncio.to_thread(make_reports, run.folder)
    for path in made:
        run.tell("report", text=str(path))
    for line in failed:
        run.log(line)
    holes = run.history.hole_count
    run.tell(
        "finished", run.folder.name, ending.fate, ending.reason, holes=holes, outputs=encode(outputs),
        folder=str(run.folder), detail=ending.detail, points=run.history.points().words(holes),
        resumable=ending.fate != "succeeded" and not run.history.is_through, stands=bool(run.history.stands),
    )  # fmt: skip
