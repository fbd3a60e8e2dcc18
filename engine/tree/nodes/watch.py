"""`watch`: something is looked at while the steps of a group run, and may take their place."""

import ast
import asyncio
from collections import ChainMap, deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ....schemas.journal import StepEnded, Turned
from ....schemas.quantity import seconds
from ...dispatch.dispatcher import Dispatcher
from ...dispatch.request import Request
from ...journal.encode import decode, encode, with_units
from ...journal.history import LOOKS
from ...language.arguments import ArgumentFaults, resolve_arguments
from ...language.expression import STATUS, ExpressionError
from ...language.operators import words
from ...language.value import Value
from ...run.frame import Frame, Scope
from ...run.run import Run
from .action import ActionPlan
from .failure import Failure
from .finally_of_use import FinallyOfUse
from .node import Parent, failure_of, result_of
from .replay_failed import failed_anew, replay_failed

STALE_S = 5.0
"""How old what a watch knows may be at least; three times `every` where that is more."""


@dataclass(frozen=True, slots=True)
class WatchPlan:
    """What one watch states; `then` is ticked in `scope`, and is None for a pause."""

    number: int
    when: Value
    text: str
    every: Value | None
    stale: Value | None
    ignores_stale: bool
    look: ActionPlan | None
    look_id: str | None
    leaves_running: bool
    then: Behaviour | None
    scope: Scope


@dataclass(slots=True)
class Seen:
    """Why a watch is right: its condition holds, or for too long nobody has known whether it does."""

    name: str
    message: str
    read: Any = None


class Watcher:
    """One watch at work: when it looks, and what it knows since when.

    Its times are those of the computer's clock: a paused run is watched, too.
    """

    def __init__(self, run: Run, dispatcher: Dispatcher, plan: WatchPlan) -> None:
        self.run = run
        self.dispatcher = dispatcher
        self.plan = plan
        self.path = ""
        self.rises = 0
        self.holds = False
        self._frame: Frame = None  # type: ignore[assignment]  # entered before it is read
        self._every_s: float | None = None
        self._stale_s = STALE_S
        self._next_at = self._known_at = 0.0
        self._request: Request | None = None
        self._read: Any = None
        self._why_unknown = ""

    def begin(self, path: str, frame: Frame) -> None:
        """Watch from now on; raises ExpressionError, ValueError."""
        plan, names = self.plan, self.run.names(frame.names, f"{path}/w{self.plan.number}")
        self.path, self._frame = f"{path}/w{plan.number}", frame
        self._every_s = None if plan.every is None else seconds(plan.every.evaluate(names))
        self._stale_s = max(STALE_S, 3 * (self._every_s or 0.0))
        if plan.stale is not None:
            self._stale_s = seconds(plan.stale.evaluate(names))
        self._next_at = self._known_at = _now()
        self._request, self._read, self._why_unknown = None, None, ""
        past = self.run.history.past.turned.get(self.path)
        self.rises = past.turn if past is not None else 0
        self.holds = past is not None and past.error is not None and self.plan.leaves_running

    def look(self) -> Seen | None:
        """What is so now, if it has become so since the last look."""
        now = _now()
        value = self._asked(now) if self.plan.look is not None else self._by_status(now)
        late = now - self._known_at > self._stale_s and not self.plan.ignores_stale
        self._wake(now, late=late)
        if value is None and not late:
            return None
        is_so = bool(value) or late
        if is_so == self.holds:
            return None
        self.holds = is_so
        if not is_so:
            self.run.record(Turned(path=self.path, turn=self.rises))
            return None
        return self._stale(now) if late and not value else self._right()

    def end(self) -> None:
        """Look no more."""
        if self._request is not None:
            self.dispatcher.withdraw(self._request)
            self._request = None

    # --- looking

    def _wake(self, now: float, *, late: bool) -> None:
        if not late and not self.plan.ignores_stale:
            self.run.requests.look_at(self._known_at + self._stale_s + 0.001)
        if self._every_s is not None and self._request is None:
            self.run.requests.look_at(max(self._next_at, now + 0.001))

    def _by_status(self, now: float) -> bool | None:
        if self._every_s is not None:
            if now < self._next_at:
                return None
            self._next_at = now + self._every_s
        return self._evaluate(now)

    def _asked(self, now: float) -> bool | None:
        """The condition, with what has just been read; None while nothing new has been."""
        request = self._request
        if request is None:
            if now >= self._next_at:
                self._next_at = now + (self._every_s or STALE_S)
                self._ask()
            return None
        if request.outcome is None:
            if request.cut:
                self._request = None
            return None
        self._request = None
        outcome, plan = request.outcome, self.plan.look
        assert plan is not None
        if outcome.state != "SUCCEEDED":
            said = outcome.error.message if outcome.error is not None else outcome.state
            self._unknown(f"{plan.label}: {said}")
            return None
        self._read = with_units(outcome.result or {}, plan.action.returns)
        if self.plan.look_id is not None:
            self._frame.store(self.plan.look_id, self._read)
        return self._evaluate(now)

    def _ask(self) -> None:
        plan, path = self.plan.look, f"{self.path}{LOOKS}"
        assert plan is not None
        names = self._names(_now(), [])
        try:
            given = plan.arguments.evaluate(names)
            arguments = resolve_arguments(plan.action, given, plan.role.limits, label=plan.label)
        except (ExpressionError, ArgumentFaults, ValueError) as fault:
            self._unknown(str(fault))
            return
        attempt = 1 + max(self.run.history.past.goals.get(path, {0: None}))
        self._request = Request(
            goal_id=f"{self.run.id}/{path}/{attempt}", path=path, role=plan.role,
            action_name=plan.action_name, action=plan.action, params=arguments,
            timeout_s=self._stale_s, within=self._frame.owner.path, urgent=True,
        )  # fmt: skip
        self.dispatcher.request(self._request)

    def _evaluate(self, now: float) -> bool | None:
        told_at: list[float] = []
        try:
            value = bool(self.plan.when.evaluate(self._names(now, told_at)))
        except (ExpressionError, ValueError) as fault:
            self._unknown(str(fault))
            return None
        if now - min(told_at, default=now) <= self._stale_s:
            self._why_unknown = ""
        self._known_at = max(self._known_at, min(told_at, default=now))
        return value

    def _names(self, now: float, told_at: list[float]) -> Mapping[str, Any]:
        own: dict[str, Any] = {
            "now()": self.run.clock.time_of_day, "elapsed()": self.run.elapsed,
        }  # fmt: skip
        if STATUS not in self._frame.names:
            own[STATUS] = Statuses(self.dispatcher, self.run, told_at, now)
        return ChainMap(own, *self._frame.names.maps)

    def _unknown(self, why: str) -> None:
        if why != self._why_unknown:
            self._why_unknown = why
            self.run.log(f"watch: {why}", self.path)

    # --- saying

    def _right(self) -> Seen:
        told: list[str] = []
        names = self._names(_now(), [])
        for one in self.plan.when.expressions():
            for field in dict.fromkeys(_fields(one.tree)):
                value = names[STATUS][field[0]].get(field[1]) if STATUS in names else None
                told.append(f"{field[0]}.{field[1]} is {words(value)}")
        seen = f" ({', '.join(told)})" if told else ""
        return Seen("Watched", f"{self.plan.text}{seen}", self._read)

    def _stale(self, now: float) -> Seen:
        why = f": {self._why_unknown}" if self._why_unknown else ""
        for_s = now - self._known_at
        message = f"nobody knows whether {self.plan.text}: nothing for {for_s:.1f} s{why}"
        return Seen("Stale", message, self._read)


class Statuses(Mapping[str, Any]):
    """`status` in a condition that is watched: by role, what its device has told, and when."""

    def __init__(self, dispatcher: Dispatcher, run: Run, told_at: list[float], now: float) -> None:
        self.dispatcher, self.run, self.told_at, self.now = dispatcher, run, told_at, now

    def __getitem__(self, role: str) -> Any:
        if role not in self.run.roles:
            raise KeyError(role)
        bound = self.run.roles[role]
        values, at = self.dispatcher.status(bound.device)
        self.told_at.append(at)
        return with_units(values, bound.contract.status)

    def __iter__(self) -> Iterator[str]:
        return iter(self.run.roles)

    def __len__(self) -> int:
        return len(self.run.roles)


class WatchedGroup(Parent):
    """Steps with their watches. One that is right has the steps cancelled, and `then` decides.

    That a watch was right is in the journal before anything is done about it: a run that goes on behind it
    does what its steps had done and set, and continues with `then`. Only where the run had
    failed since, or was aborted, do the steps go on where they were; they are watched again.
    """

    def __init__(
        self, name: str, run: Run, scope: Scope, body: Behaviour, watchers: list[Watcher]
    ) -> None:
        thens = [w.plan.then for w in watchers if w.plan.then is not None]
        super().__init__(name, run, [body, *thens])
        self.scope = scope
        self.body = body
        self.watchers = watchers
        self.fired: Watcher | None = None
        self.gone = False
        self.finally_due: FinallyOfUse | None = None
        self.telling: deque[Behaviour] = deque()

    @property
    def path(self) -> str:
        """The current path of the group."""
        return f"{self.scope.frame.path}/{self.name}"

    def initialise(self) -> None:
        self.fired, self.gone, self.finally_due = None, False, None
        self.telling.clear()
        try:
            for watcher in self.watchers:
                watcher.begin(self.path, self.scope.frame)
                self._remember(watcher)
        except (ExpressionError, ValueError) as fault:
            self.status = self.fail(Failure("Expression", str(fault), step=self.path))

    def _remember(self, watcher: Watcher) -> None:
        """A watch that was right in an earlier session, unless what came of it has failed since."""
        done = self.run.past
        past = done.turned.get(watcher.path)
        if past is None or past.error is None or watcher.plan.leaves_running:
            return
        if done.is_before_change(past) and watcher.plan.text not in past.error["message"]:
            watcher.dispatcher.another_watch(self.path, past.error["message"], watcher.plan.text)
            said = f"its watch was right ({past.error['message']}), and is another one now"
            self.status = self.fail(Failure("Rejected", said, step=self.path, stop=True))
            return
        over = f"{watcher.path}.{past.turn}" in done.steps
        if self.replaying or over or not done.is_over(past):
            self.fired, self.gone = watcher, True
            done.forget_under_way(self.path, past.n)
            self._enter(watcher, past.error)

    def advance(self) -> None:
        if self.fired is None and not (self.replaying or self.run.past.comparing):
            self._look()
        self._tell()
        if self.fired is None:
            self._steps()
        else:
            self._instead(self.fired)

    def _look(self) -> None:
        for watcher in self.watchers:
            seen = watcher.look()
            if seen is not None:
                self._rise(watcher, seen)
            if self.fired is not None:
                return

    def _rise(self, watcher: Watcher, seen: Seen) -> None:
        watcher.rises += 1
        error = Failure(seen.name, seen.message, step=self.path).as_error()
        self.run.record(
            Turned(
                path=watcher.path, turn=watcher.rises, error={**error, "read": encode(seen.read)}
            )
        )  # fmt: skip
        self.run.log(f"watch: {seen.message}", self.path)
        then = watcher.plan.then
        if then is None:
            self.run.requests.pause = f"{seen.message}; `labrun continue` goes on"
            return
        self._enter(watcher, error)
        if watcher.plan.leaves_running:
            self.telling.append(then)
            return
        self.fired = watcher
        self.body.stop(Status.INVALID)
        self._end_watches()

    def _enter(self, watcher: Watcher, error: dict[str, Any]) -> None:
        if watcher.plan.look_id is not None and "read" in error:
            self.scope.frame.store(watcher.plan.look_id, decode(error["read"]))
        names = {"error": {key: value for key, value in error.items() if key != "read"}}
        frame = self.scope.frame.within(f"{watcher.path}.{watcher.rises}", names)
        frame.urgent = True
        watcher.plan.scope.frame = frame

    # --- the steps, or what takes their place

    def _tell(self) -> None:
        while self.telling:
            self.telling.popleft().tick_once()

    def _steps(self) -> None:
        self.body.tick_once()
        if self.body.status == Status.SUCCESS:
            self.result = result_of(self.body)
            self.status = Status.SUCCESS
        elif self.body.status == Status.FAILURE:
            self.status = self.fail(failure_of(self.body))

    def _instead(self, watcher: Watcher) -> None:
        if self.gone:
            replay_failed(self.body)
            if self.body.status == Status.RUNNING:
                return
            self.gone = False
            if (anew := failed_anew(self.body)) is not None:
                self.status = self.fail(anew)
                return
        self.finally_due = self.finally_due or FinallyOfUse(self, [self.path])
        self.finally_due.tick_once()
        then = watcher.plan.then
        if self.finally_due.due or then is None:
            return
        then.tick_once()
        if then.status == Status.FAILURE:
            self.status = self.fail(_with_cause(failure_of(then), watcher))
        elif then.status == Status.SUCCESS:
            over = f"{watcher.path}.{watcher.rises}"
            if over not in self.run.history.past.steps:
                self.run.record(StepEnded(path=over, fate="succeeded"))
            self.result = result_of(then)
            self.status = Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        if self.finally_due is not None and new_status == Status.INVALID:
            self.finally_due.stop()
        self._end_watches()

    def _end_watches(self) -> None:
        for watcher in self.watchers:
            watcher.end()


def _with_cause(failure: Failure, watcher: Watcher) -> Failure:
    """A dead sensor is told as that, not by the words that `fail` has for what nobody has seen."""
    error = watcher.plan.scope.frame.names["error"]
    if failure.name != "Failed" or error["name"] != "Stale" or error["message"] in failure.message:
        return failure
    return replace(failure, message=f"{error['message']} (watched for: {failure.message})")


def _now() -> float:
    return asyncio.get_running_loop().time()


def _fields(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Role and field of every `status.ROLE.FIELD`."""
    for node in ast.walk(tree):
        if not (isinstance(node, ast.Attribute) and isinstance(node.value, ast.Attribute)):
            continue
        if isinstance(node.value.value, ast.Name) and node.value.value.id == STATUS:
            yield node.value.attr, node.attr
