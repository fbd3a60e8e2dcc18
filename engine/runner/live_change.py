"""Change the protocol of a live run: it comes to rest between two actions, and goes on with a new tree.

Until the record of the change is on disk, the run is what it was, and after it what it is to be: an
engine that is killed at any moment leaves one of the two.
"""

import asyncio
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
from itertools import takewhile
from pathlib import Path
from typing import Any

from ...schemas import journal as j
from ...system.tasks import spawn
from ..check import Checked
from ..control.control import Control
from ..journal.history import read_history
from ..journal.journal import Records
from ..problems.print import print_problems
from ..run.folder import FolderFault, newest_copies
from ..run.run import Run

TRIES = 5
"""How often the run may do something of its own while a change is held against what it has done."""

Answer = tuple[bool, str]


@dataclass(frozen=True, slots=True)
class Wanted:
    """A change that was asked for, checked; `given`: the parameters as a person wrote them."""

    checked: Checked
    given: dict[str, str]
    yes: bool
    by: str


class Refused(Exception):
    """Why a change does not come about."""


class LiveChange:
    """The change of one live run that is asked for, if any: compared with the run at rest, then made."""

    def __init__(self, run: Run, control: Control, devices: Mapping[str, Any]) -> None:
        self.run, self.control, self.devices = run, control, devices
        self._possible = False
        self._wanted: Wanted | None = None
        self._answer: asyncio.Future[Answer] | None = None
        self._holding: asyncio.Task[j.Changed] | None = None
        """The comparison, and the copies that it allows."""
        self._held_n = self._tries = 0
        control.change_due = self.is_due

    @contextmanager
    def possible(self) -> Iterator[None]:
        """While the body runs, the protocol may be changed; what is not made by its end is refused."""
        self._possible = True
        try:
            yield
        finally:
            self._possible = False
            self._say(False, "its steps ended, or a device was lost, before that")

    async def ask(self, asked: dict[str, Any]) -> Answer:
        """Change the protocol; the answer comes when that is done, or says why it is not.

        `asked`: `file`, `params`, `yes` (keep work that is in doubt) and `by`.
        """
        if self._answer is not None:
            return False, "another change of this run is under way"
        if not self._possible:
            return (
                False,
                "only a run that is at its steps can be changed; this one is before or behind them",
            )
        answer = self._answer = asyncio.get_running_loop().create_future()
        self._tries, by = 0, str(asked.get("by", ""))
        self.control.hold(f"{by}, to change the protocol")
        try:
            wanted = await asyncio.to_thread(self._check, asked)
            if not answer.done():
                self._wanted = wanted
                self.control.wake()
            return await answer
        except (Refused, FolderFault) as fault:
            return False, str(fault)
        finally:
            self.control.let_go(by)
            if self._holding is not None:  # a thread cannot be cancelled
                await asyncio.wait({self._holding})
            self._answer = self._wanted = self._holding = None

    def is_due(self, busy: bool) -> bool:
        """True once nothing runs, and the work that is done allows the change; asked in each round."""
        if self._wanted is None or self._answer is None or self._answer.done():
            return False
        if not self.control.paused:
            self._say(False, "it was continued, or aborted, before it came to rest")
        elif not busy and self._holding is None:
            self.run.journal.flush()
            self._held_n = self.run.history.work_n
            changes = len(self.run.history.changes)
            hold = asyncio.to_thread(self._hold, self._wanted, self.run.history.last_n, changes)
            self._holding = spawn(
                "hold a change against the run", hold, expected=(Refused, OSError)
            )
            self._holding.add_done_callback(lambda _: self.control.wake())
        elif not busy and self._holding is not None and self._holding.done():
            return self._is_still_so(self._holding)
        return False

    def _is_still_so(self, holding: "asyncio.Task[j.Changed]") -> bool:
        fault = None if holding.cancelled() else holding.exception()
        if fault is not None:
            self._say(False, f"{fault} The run goes on as it was.")
        elif self.run.history.work_n == self._held_n:
            return True
        elif self._tries >= TRIES:
            self._say(False, "it does not come to rest; it goes on as it was")
        else:
            self._tries, self._holding = self._tries + 1, None
            self.run.requests.again()
        return False

    async def make(self, plant: Callable[[Checked], None]) -> None:
        """Write the record, and plant the new tree; no goal is under way."""
        assert self._wanted is not None and self._holding is not None
        record, checked = self._holding.result(), self._wanted.checked
        self.run.record(record)
        self.run.journal.flush()
        if record.reopened:  # what was done in them was forgotten when they ended
            records = Records(self.run.journal.path)
            self.run.history = await asyncio.to_thread(read_history, records)
        self._take(checked)
        plant(checked)
        self._say(True, f"the run goes on with the changed protocol ({record.folder})")

    def _take(self, checked: Checked) -> None:
        assert checked.protocol is not None
        run, playing = self.run, {role.device for role in checked.roles.values()}
        # A device without a role any more is made safe at the end like the others.
        former = {f"former {r.device}": r for r in run.roles.values() if r.device not in playing}
        run.roles = {**former, **checked.roles}
        run.params = checked.params
        run.about = {**run.about, "name": checked.protocol.name}

    def _say(self, ok: bool, text: str) -> None:
        wanted, answer = self._wanted, self._answer
        words = text if ok else f"not changed: {text}"
        if answer is not None and not answer.done():
            answer.set_result((ok, words))
            if wanted is not None:
                self.run.log(f"{words} ({wanted.by})")

    # --- in a thread

    def _check(self, asked: dict[str, Any]) -> Wanted:
        from .change import check_copy

        file = asked.get("file")
        place = newest_copies(self.run.folder, self.run.history)
        params = {str(name): str(value) for name, value in (asked.get("params") or {}).items()}
        checked, given = check_copy(place, Path(file) if file else None, params)
        if not checked.ok:
            told = StringIO()
            print_problems(checked.problems, format="text", file=told)
            raise Refused(told.getvalue().rstrip())
        more = sorted({r.device for r in checked.roles.values()} - self.devices.keys())
        if more:
            raise Refused(
                f"the changed protocol needs {', '.join(more)}, and a live run takes no further device. "
                f"Abort it, then `labrun resume {self.run.folder.name} --changed FILE`"
            )
        return Wanted(checked, given, asked.get("yes") is True, str(asked.get("by", "")))

    def _hold(self, wanted: Wanted, n: int, changes: int) -> j.Changed:
        from .change import keep_change, why_not
        from .compare import compare

        records = takewhile(lambda record: record.n <= n, Records(self.run.journal.path))
        found = compare(wanted.checked, list(records))
        if why := why_not(found, yes=wanted.yes):
            raise Refused(why)
        return keep_change(self.run.folder, wanted.checked, wanted.given, changes, found.reopened)
