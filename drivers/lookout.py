"""Look after goals that are under way on one server: none is forgotten, none is guessed about."""

import asyncio
import contextlib
from collections.abc import Callable, Iterable

from pydantic import ValidationError

from ..schemas.messages import Goal, GoalReport, QueryAnswer
from .following import Following, ledger_of
from .link import Answer, Link, LinkDown, accepted
from .outcome import Outcome, lost, out_of_reach, outcome_of, refused

LOOK_S = 0.5
"""How often goals are looked after that have not been heard of."""

REPORT_FIELDS = frozenset(GoalReport.model_fields)


class Lookout:
    """Goals from being sent to their end; `update` is a hint, the answer to `query` the truth."""

    def __init__(self, link: Link, lost_after_s: float) -> None:
        self.boot = ""
        self._link = link
        self._lost_after_s = lost_after_s
        self._followed: dict[str, Following] = {}
        self._wake = asyncio.Event()
        self._watcher: asyncio.Task[None] | None = None

    def open(self) -> None:
        """Begin to watch."""
        self._watcher = asyncio.create_task(self._watch())

    async def close(self) -> None:
        """Watch no longer; what is still followed is out of reach."""
        if self._watcher is not None:
            self._watcher.cancel()
            await asyncio.gather(self._watcher, return_exceptions=True)
            self._watcher = None
        for following in self._followed.values():
            following.conclude(out_of_reach(f"the connection to {self._link.url} was closed"))

    async def follow(
        self, goal: Goal, on_report: Callable[[GoalReport], None], *, send: bool = True
    ) -> Outcome:
        """Send a goal, or only ask after it, and wait for its end."""
        if goal.id in self._followed:
            raise ValueError(f"goal {goal.id} is followed already")
        following = Following(goal, on_report, may_send=send)
        self._followed[goal.id] = following
        try:
            if send and goal.boot == self.boot and self._link.up.is_set():
                await self._send(following)
            else:
                self._doubt(following)
            return await following.end
        finally:
            del self._followed[goal.id]

    def doubt_all(self) -> None:
        """The connection came or went: ask what became of every goal as soon as one can."""
        for following in self._followed.values():
            self._doubt(following)

    def update(self, data: Answer) -> None:
        """The server tells of a goal by itself."""
        following = self._followed.get(data.get("id", ""))
        if following is not None:
            self._reported(following, data)

    async def cancel(self, goal_id: str) -> None:
        """Ask for a goal's end; raises LinkDown only where nobody would ask again later."""
        following = self._followed.get(goal_id)
        if following is not None:
            following.cancel_wanted = True
        try:
            answer = await self._link.call("cancel", {"id": goal_id})
        except LinkDown:
            if following is None:
                raise
            self._doubt(following)
        else:
            if following is not None and answer.get("ok"):
                following.cancel_wanted = False

    async def query(self, ids: Iterable[str]) -> QueryAnswer:
        """What the server knows of goals; raises LinkDown."""
        answer = accepted(await self._link.call("query", {"ids": list(ids)}), self._link.url)
        goals = {i: None if data is None else _report(data) for i, data in answer["goals"].items()}
        return QueryAnswer(boot=answer["boot"], ledger=answer["ledger"], goals=goals)

    async def _send(self, following: Following) -> None:
        def answered(answer: Answer) -> None:
            self._answered(following, answer)

        following.sent()
        if not await self._link.send("goal", following.payload, answered):
            self._doubt(following)

    def _answered(self, following: Following, answer: Answer) -> None:
        if answer.get("ok"):
            self._reported(following, answer)
        elif _was_ours(answer, following.goal):
            following.refusal, following.lapsed = answer.get("message", ""), True
            self._doubt(following)
        elif answer.get("code") in ("STALE_BOOT", "EXCEPTION"):
            following.refusal = answer.get("message", "")
            self._doubt(following)
        else:
            code, message = answer.get("code", ""), answer.get("message", "")
            following.conclude(refused(code, message, self.boot))

    def _reported(self, following: Following, data: Answer) -> None:
        try:
            report = _report(data)
        except ValidationError:  # a server of another version: `query` will have the last word
            self._doubt(following)
            return
        following.heard()
        if report.ended:
            following.conclude(outcome_of(report))
        else:
            following.tell(report)

    def _doubt(self, following: Following) -> None:
        following.doubtful = True
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

    async def _find_out(self, in_doubt: list[Following]) -> None:
        try:
            if not self._link.up.is_set():
                raise LinkDown(f"there is no connection to {self._link.url}")
            answer = await self.query(following.goal.id for following in in_doubt)
            for following in in_doubt:
                await self._judge(following, answer)
        except Exception as fault:  # whatever a server answers, the others are looked after
            for following in in_doubt:
                if following.silent_s() > self._lost_after_s:
                    words = f"not heard of for {following.silent_s():.0f} s: {fault}"
                    following.conclude(out_of_reach(words))

    async def _judge(self, following: Following, answer: QueryAnswer) -> None:
        """Conclude from the server's own record, or send again what surely never arrived."""
        goal = following.goal
        report = answer.goals.get(goal.id)
        following.doubtful = False
        if report is not None and report.ended:
            following.conclude(outcome_of(report))
        elif report is not None:
            following.heard()
            following.tell(report)
            if following.cancel_wanted:
                await self.cancel(goal.id)
        elif answer.boot == goal.boot:
            await self._never_arrived(following)
        elif ledger_of(goal.boot) == answer.ledger:
            words = "the device server was started anew before the goal reached it"
            following.conclude(lost(words, "no", answer.boot))
        else:
            words = "the device server keeps another ledger now, which knows nothing of the goal"
            following.conclude(lost(words, "unknown", answer.boot))

    async def _never_arrived(self, following: Following) -> None:
        """Same boot, no record: the goal is on its way or was lost on it."""
        too_late = following.silent_s() > self._lost_after_s
        stays = following.cancel_wanted or following.refusal or too_late or not following.may_send
        if not stays:
            await self._send(following)
            return
        # The tombstone makes sure of it before anything is concluded: a late goal cannot start.
        answer = await self._link.call("cancel", {"id": following.goal.id})
        if accepted(answer, self._link.url)["state"] != "CANCELED":
            self._doubt(following)  # it arrived after all, and its record says how it stands
        elif following.lapsed:
            words = (
                f"the lease was taken anew before the goal reached its device: {following.refusal}"
            )
            following.conclude(lost(words, "no", self.boot))
        elif following.refusal:
            following.conclude(refused("REJECTED", following.refusal, self.boot))
        elif too_late or not (following.may_send or following.cancel_wanted):
            words = "the device server never received the goal"
            following.conclude(lost(words, "no", self.boot))
        else:
            following.conclude(Outcome("CANCELED", boot=self.boot))


def _was_ours(answer: Answer, goal: Goal) -> bool:
    """True for a lease that is over and that nobody else has taken: its owner is the goal's run."""
    own = goal.id.partition("/")[0]
    return answer.get("code") == "STALE_EPOCH" and answer.get("holder", own) == own


def _report(data: Answer) -> GoalReport:
    return GoalReport.model_validate({n: v for n, v in data.items() if n in REPORT_FIELDS})
