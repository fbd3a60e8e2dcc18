"""One goal that a client follows: when it was last heard of, and how it ended."""

import asyncio
from collections.abc import Callable
from typing import Any

from ..schemas.messages import Goal, GoalReport
from .link import ANSWER_S
from .outcome import Outcome

BEAT_MISSED_S = 5.0
"""A goal under way is heard of each second; after this long the server is asked."""


class Following:
    """What a client knows of a goal between sending it and its end."""

    def __init__(
        self, goal: Goal, on_report: Callable[[GoalReport], None], *, may_send: bool = True
    ) -> None:
        self.goal = goal
        self.may_send = may_send
        self.lapsed = False
        self._on_report = on_report
        self.payload: dict[str, Any] = goal.model_dump(exclude_defaults=True)
        self.doubtful = False
        self.cancel_wanted = False
        self.refusal = ""
        self._loop = asyncio.get_running_loop()
        self.end: asyncio.Future[Outcome] = self._loop.create_future()
        self._heard_at = self._loop.time()
        self._patient_until = self._heard_at + ANSWER_S

    def sent(self) -> None:
        """It went out; its answer is due soon."""
        self._patient_until = self._loop.time() + ANSWER_S

    def heard(self) -> None:
        """The server spoke of it."""
        self._heard_at = self._loop.time()
        self._patient_until = self._heard_at + BEAT_MISSED_S

    def silent_s(self) -> float:
        """For how long nothing was heard of it."""
        return self._loop.time() - self._heard_at

    def in_doubt(self) -> bool:
        """True when the server has to be asked what became of it."""
        return not self.end.done() and (self.doubtful or self._loop.time() > self._patient_until)

    def tell(self, report: GoalReport) -> None:
        """Pass on how it goes; a fault of the listener comes out where the goal is awaited."""
        if self.end.done():
            return
        try:
            self._on_report(report)
        except Exception as fault:
            self.end.set_exception(fault)

    def conclude(self, outcome: Outcome) -> None:
        """It has ended; the first word stands."""
        if not self.end.done():
            self.end.set_result(outcome)


def ledger_of(boot: str) -> str:
    """The id of the ledger that a boot was made for: the part before its dot."""
    return boot.partition(".")[0]
