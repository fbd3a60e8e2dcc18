"""Find the used protocols in which a run was when it was interrupted: their `on_resume` is due.

The protocol's own tree is run against the journal, as far as the journal goes. Nothing is sent, nothing is
written, and what is not done yet stays undone: the tree comes to rest where the run was.
"""

import asyncio
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from py_trees.common import Status

from ...schemas.protocol import Protocol
from ..dispatch.dispatcher import Dispatcher
from ..dispatch.request import Request
from ..journal.history import read_history
from ..journal.journal import Records
from ..run.finals import DueFinals
from ..run.frame import Frame, Scope
from ..run.open_uses import OpenUse
from ..run.questions import Questions
from ..run.requests import Requests
from ..run.run import Run
from ..run.strands import Strands
from ..survey.survey import Survey
from ..tree.compile import TreeCompiler
from .compare import Unwritten


async def uses_under_way(
    run: Run, protocol: Protocol, survey: Survey, told: Callable[[str], Any]
) -> list[OpenUse]:
    """Those that had begun, the outermost first; none if no used protocol has an `on_resume`."""
    if not _has_on_resume(survey):
        return []
    run.journal.flush()
    with tempfile.TemporaryDirectory(prefix="labrun-resume-") as folder:
        return await _found(run, protocol, survey, told, Path(folder))


def _has_on_resume(survey: Survey) -> bool:
    used = survey.used.values()
    return any(one.protocol.on_resume or _has_on_resume(one.survey) for one in used)


async def _found(
    run: Run, protocol: Protocol, survey: Survey, told: Callable[[str], Any], folder: Path
) -> list[OpenUse]:
    history = read_history(Records(run.journal.path))
    history.touched.clear()  # to set something again comes later: here it counts as done
    past = history.past.copy()
    scratch = replace(
        run, folder=folder, journal=Unwritten(folder / "journal.jsonl", sync=False), history=history,
        past=past, questions=Questions(), listeners={}, requests=Requests(), finals=DueFinals(),
        strands=Strands(), open_uses={}, call=_call_nothing, told=told, left_undone={},
        notify=lambda text, picture: None,
    )  # fmt: skip
    dispatcher = _Unsent(scratch, {})
    names = {"params": run.params, "run": run.about, "csv": survey.tables}
    compiler = TreeCompiler(scratch, dispatcher, survey, folder)
    root = compiler.sequence(protocol.steps, Scope(Frame.phase("main", names)))
    again = True
    while again:
        root.tick_once()
        dispatcher.grant_all()
        again = scratch.requests.take_round()[0] and root.status == Status.RUNNING
        await asyncio.sleep(0)
    found = [use for use in scratch.open_uses.values() if past.has_begun(use.path)]
    root.stop(Status.INVALID)
    scratch.journal.close()
    return found


async def _call_nothing(*_: Any) -> Any:
    await asyncio.Event().wait()


class _Unsent(Dispatcher):
    """Sends nothing, and so nothing ends; a group that asks for devices has them, since none is used."""

    def request(self, request: Request, *, first: bool = False) -> Request:
        return request

    def withdraw(self, request: Request) -> None:
        pass

    def grant_all(self) -> None:
        for one in self.reservations.waiting:
            one.granted = True
            self.run.requests.again()
        self.reservations.held += self.reservations.waiting
        self.reservations.waiting = []
