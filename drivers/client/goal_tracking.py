"""One goal that a client follows: its last sign of life, and how it ended."""

import asyncio
from collections.abc import Callable
from typing import Any

from ...schemas.messages import Goal, GoalReport
from .link import ANSWER_S
from .outcome import Outcome

BEAT_MISSED_S = 5.0
"""A running goal is reported every second; after this much silence the server is queried."""


class GoalTracking:
    """What a client knows about a goal between sending it and its end."""

    def __init__(
        self, goal: Goal, on_report: Callable[[GoalReport], None], *, may_send: bool = True
    ) -> None:
        self.goal = goal
        self.may_send = may_send
        self.lapsed = False
        self._on_report = on_report
        self.payload: dict[str, Any] = goal.model_dump(exclude_defaults=True)
        self.doubtful = False
        self.forgotten = False
        self.ending = False
        self.cancel_wanted = False
        self.refusal = ""
        self._loop = asyncio.get_running_loop()
        self.end: asyncio.Future[Outcome] = self._loop.create_future()
        self._heard_at = self._loop.time()
        self._patient_until = self._heard_at + ANSWER_S

    def sent(self) -> None:
        """Note that it was sent; its answer is due soon."""
        self._patient_until = self._loop.time() + ANSWER_S

    def heard(self) -> None:
        """Note that the server reported on it."""
        self._heard_at = self._loop.time()
        self._patient_until = self._heard_at + BEAT_MISSED_S

    def silent_s(self) -> float:
        """Seconds since the last report on it."""
        return self._loop.time() - self._heard_at

    def in_doubt(self) -> bool:
        """True when the server has to be queried about it."""
        return not self.end.done() and (self.doubtful or self._loop.time() > self._patient_until)

    def tell(self, report: GoalReport) -> None:
        """Pass on a progress report; an error in the listener is raised where the goal is awaited."""
        if self.end.done():
            return
        try:
            self._on_report(report)
        except Exception as fault:  # whatever it is, it is raised where the goal is awaited
            self.end.set_exception(fault)

    def conclude(self, outcome: Outcome) -> None:
        """Record its end; the first outcome counts."""
        if not self.end.done():
            self.end.set_result(outcome)
