"""Watch the goals running on one server: none is forgotten, no outcome is guessed."""

import asyncio
import contextlib
import logging
from collections.abc import Callable, Iterable, Iterator

from pydantic import ValidationError

from ...schemas.messages import Goal, GoalReport, QueryAnswer, ledger_of
from ...system.tasks import end, keep
from .goal_tracking import GoalTracking
from .link import Answer, Link, LinkDown, ServerUnreachable, accepted
from .outcome import Outcome, lost, out_of_reach, outcome_of, refused

LOOK_S = 0.5
"""How often goals without news are checked."""

LOG = logging.getLogger("labrun")
REPORT_FIELDS = frozenset(GoalReport.model_fields)


class GoalWatch:
    """Goals from sending to end; `update` is a hint, the answer to `query` is the truth."""

    def __init__(self, link: Link, lost_after_s: float) -> None:
        self.boot = ""
        self._link = link
        self._lost_after_s = lost_after_s
        self._followed: dict[str, GoalTracking] = {}
        self._wake = asyncio.Event()
        self._watcher: asyncio.Task[None] | None = None

    def open(self) -> None:
        """Start watching."""
        self._watcher = keep(f"watching the goals of {self._link.url}", self._watch)

    async def close(self) -> None:
        """Stop watching; goals still followed end as out of reach."""
        await end(self._watcher)
        self._watcher = None
        for tracking in self._followed.values():
            tracking.conclude(out_of_reach(f"the connection to {self._link.url} was closed"))

    async def follow(
        self, goal: Goal, on_report: Callable[[GoalReport], None], *, send: bool = True
    ) -> Outcome:
        """Send a goal, or only query it, and wait for its end."""
        if goal.id in self._followed:
            raise ValueError(f"goal {goal.id} is already being followed")
        tracking = GoalTracking(goal, on_report, may_send=send)
        self._followed[goal.id] = tracking
        try:
            if send and goal.boot == self.boot and self._link.up.is_set():
                await self._send(tracking)
            else:
                self._doubt(tracking)
            return await tracking.end
        finally:
            del self._followed[goal.id]

    def doubt_all(self) -> None:
        """The connection came or went: query every goal as soon as possible."""
        for tracking in self._followed.values():
            self._doubt(tracking)

    def lose_memory(self) -> None:
        """The server has another ledger now: that it does not know a goal proves nothing."""
        for tracking in self._followed.values():
            tracking.forgotten = True

    def update(self, data: Answer) -> None:
        """Take an unsolicited report on a goal."""
        tracking = self._followed.get(data.get("id", ""))
        if tracking is not None:
            self._reported(tracking, data)

    async def cancel(self, goal_id: str) -> None:
        """Request a goal's end; raises LinkDown only if nothing would retry later."""
        tracking = self._followed.get(goal_id)
        if tracking is not None:
            tracking.cancel_wanted = True
        request = {"id": goal_id} | ({} if tracking is None else {"boot": tracking.goal.boot})
        try:
            answer = await self._link.call("cancel", request)
        except LinkDown:
            if tracking is None:
                raise
            self._doubt(tracking)
        else:
            if tracking is not None and answer.get("ok"):
                tracking.cancel_wanted = False
            elif tracking is not None:
                self._doubt(tracking)

    async def query(self, ids: Iterable[str]) -> QueryAnswer:
        """What the server knows about goals; raises LinkDown."""
        answer = await self._records(ids)
        goals = {i: None if data is None else _report(data) for i, data in answer["goals"].items()}
        return QueryAnswer(boot=answer["boot"], ledger=answer["ledger"], goals=goals)

    async def _records(self, ids: Iterable[str]) -> Answer:
        return accepted(await self._link.call("query", {"ids": list(ids)}), self._link.url)

    async def _send(self, tracking: GoalTracking) -> None:
        def answered(answer: Answer) -> None:
            self._answered(tracking, answer)

        tracking.sent()
        if not await self._link.send("goal", tracking.payload, answered):
            self._doubt(tracking)

    def _answered(self, tracking: GoalTracking, answer: Answer) -> None:
        if answer.get("ok"):
            self._reported(tracking, answer)
        elif _was_ours(answer, tracking.goal):
            tracking.refusal, tracking.lapsed = answer.get("message", ""), True
            self._doubt(tracking)
        elif answer.get("code") == "ENDING":
            tracking.ending = tracking.doubtful = True
        elif answer.get("code") in ("STALE_BOOT", "EXCEPTION"):
            tracking.refusal = answer.get("message", "")
            self._doubt(tracking)
        else:
            code, message = answer.get("code", ""), answer.get("message", "")
            tracking.conclude(refused(code, message, self.boot))

    def _reported(self, tracking: GoalTracking, data: Answer) -> None:
        try:
            report = _report(data)
        except ValidationError:  # a server of another version: the answer to `query` decides
            self._doubt(tracking)
            return
        tracking.heard()
        if report.ended:
            tracking.conclude(outcome_of(report))
        else:
            tracking.tell(report)

    def _doubt(self, tracking: GoalTracking) -> None:
        tracking.doubtful = True
        self._wake.set()

    async def _watch(self) -> None:
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(LOOK_S):
                    await self._wake.wait()
            self._wake.clear()
            in_doubt = [f for f in self._followed.values() if f.in_doubt()]
            if in_doubt:
                await self._find_out(in_doubt)

    async def _find_out(self, in_doubt: list[GoalTracking]) -> None:
        with self._patience(*in_doubt):
            if not self._link.up.is_set():
                raise LinkDown(f"there is no connection to {self._link.url}")
            answer = await self._records(tracking.goal.id for tracking in in_doubt)
            for tracking in in_doubt:
                with self._patience(tracking):
                    await self._judge(tracking, answer)

    @contextlib.contextmanager
    def _patience(self, *in_doubt: GoalTracking) -> Iterator[None]:
        """After any fault within, goals are asked about again, until they were silent too long."""
        try:
            yield
        except Exception as fault:  # the fault of one goal must not cost another its outcome
            for tracking in in_doubt:
                if tracking.silent_s() > self._lost_after_s:
                    words = f"no report for {tracking.silent_s():.0f} s: {fault}"
                    never = lost(f"the device server ended before the goal began; {words}", "no")
                    tracking.conclude(never if tracking.ending else out_of_reach(words))
                    if not isinstance(fault, (LinkDown, ServerUnreachable)):
                        LOG.exception("goal %s ends as unknown", tracking.goal.id)

    async def _judge(self, tracking: GoalTracking, answer: Answer) -> None:
        """Conclude from the server's own record, or resend what certainly never arrived."""
        goal = tracking.goal
        record = answer["goals"].get(goal.id)
        report = None if record is None else _report({**record, "mark": answer.get("mark", "")})
        tracking.doubtful = False
        if report is not None and report.ended:
            tracking.conclude(outcome_of(report))
        elif report is not None:
            tracking.heard()
            tracking.tell(report)
            if tracking.cancel_wanted:
                await self.cancel(goal.id)
        elif answer["boot"] == goal.boot:
            await self._never_arrived(tracking)
        elif tracking.ending or (
            ledger_of(goal.boot) == answer["ledger"] and not tracking.forgotten
        ):
            # A run that is put back from before it was sent again begins with this id once more.
            if await self._buried(tracking, {}):
                words = "the device server was restarted before the goal reached it"
                tracking.conclude(lost(words, "no", answer["boot"]))
        else:
            words = (
                "the ledger of its device server was replaced, or put back from an older copy, and "
                "does not know this action"
            )
            tracking.conclude(lost(words, "unknown", answer["boot"]))

    async def _never_arrived(self, tracking: GoalTracking) -> None:
        """Same boot, no record: the goal is on its way or was lost."""
        too_late = tracking.silent_s() > self._lost_after_s
        if tracking.ending and not (tracking.cancel_wanted or too_late):
            tracking.doubtful = True  # refused by a server that is ending: its next boot decides
            return
        stays = tracking.cancel_wanted or tracking.refusal or too_late or not tracking.may_send
        if not stays:
            await self._send(tracking)
            return
        if not await self._buried(tracking, {"boot": tracking.goal.boot}):
            return
        if tracking.lapsed:
            words = (
                f"the lease was taken again before the goal reached its device: {tracking.refusal}"
            )
            tracking.conclude(lost(words, "no", self.boot))
        elif tracking.refusal:
            tracking.conclude(refused("REJECTED", tracking.refusal, self.boot))
        elif too_late or not (tracking.may_send or tracking.cancel_wanted):
            words = "the device server never received the goal"
            tracking.conclude(lost(words, "no", self.boot))
        else:
            tracking.conclude(Outcome("CANCELED", boot=self.boot))

    async def _buried(self, tracking: GoalTracking, of: dict[str, str]) -> bool:
        """Put up a tombstone, before anything is concluded: then a late goal cannot start."""
        answer = await self._link.call("cancel", {"id": tracking.goal.id, **of})
        buried = accepted(answer, self._link.url)["state"] == "CANCELED"
        if not buried:
            self._doubt(tracking)  # it arrived after all, and its record shows its state
        return buried


def _was_ours(answer: Answer, goal: Goal) -> bool:
    """True for a lease that is over and that no other owner has taken: it belongs to the goal's run."""
    own = goal.id.partition("/")[0]
    return answer.get("code") == "STALE_EPOCH" and answer.get("holder", own) == own


def _report(data: Answer) -> GoalReport:
    return GoalReport.model_validate({n: v for n, v in data.items() if n in REPORT_FIELDS})
