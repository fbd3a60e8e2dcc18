"""The leaf that does one action: asks the dispatcher, reads the outcome, withdraws when stopped."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from py_trees.common import Status

from ....drivers.client.client import Outcome
from ....schemas.contract import RESERVED_ERRORS, Action, Happened
from ....schemas.quantity import seconds
from ...dispatch.dispatcher import Dispatcher
from ...dispatch.request import Request, means, outcome_of
from ...journal.encode import with_units
from ...journal.past import PastGoal
from ...lab.bind import BoundRole
from ...language.arguments import ArgumentFaults, resolve_arguments
from ...language.expression import ExpressionError
from ...language.value import Value
from ...run.frame import Scope
from ...run.run import Run
from .earlier import EarlierAttempts, changed_words
from .failure import Failure
from .node import Node
from .replay_failed import came_to_here
from .unknown import UnknownFate, Verdict

LOST_AT_MOST = 3
"""How many times in a row a goal may be lost with its server before the step fails; where an action
that may be repeated has a `retry` of its own, that is the number of attempts, whatever they end with."""


@dataclass(frozen=True, slots=True)
class ActionPlan:
    """What one `do` requests, as far as it is known before it runs."""

    segment: str
    role: BoundRole
    action_name: str
    action: Action
    arguments: Value
    timeout_s: Value | None
    on_unknown: str = "probe"
    lost_at_most: int = LOST_AT_MOST

    @property
    def label(self) -> str:
        """`gantry.move_to`, as people name it."""
        return f"{self.role.role}.{self.action_name}"


class ActionLeaf(Node):
    """One attempt each time it is entered; finished attempts of earlier sessions count as done."""

    def __init__(self, run: Run, scope: Scope, dispatcher: Dispatcher, plan: ActionPlan) -> None:
        super().__init__(plan.segment, run)
        self.scope = scope
        self.dispatcher = dispatcher
        self.plan = plan
        self.earlier = EarlierAttempts(run, plan.role, plan.action)
        self.request: Request | None = None
        self.unknown: UnknownFate | None = None
        self.lost = 0
        self.repeating = False
        self.path = ""

    def initialise(self) -> None:
        self.request, self.unknown = None, None
        self.lost, self.repeating = 0, False
        self.path = self.run.past.pass_path(f"{self.scope.frame.path}/{self.plan.segment}")
        try:
            arguments = self._arguments()
            timeout_s = self._timeout(arguments)
        except (ExpressionError, ArgumentFaults, ValueError) as fault:
            self.failure = self._failure("Rejected", str(fault), "no")
            return
        self._begin(arguments, timeout_s)

    def update(self) -> Status:
        if self.failure is not None:
            return Status.FAILURE
        if self.unknown is not None:
            return self._resolve(self.unknown)
        assert self.request is not None
        outcome = self.request.outcome
        return Status.RUNNING if outcome is None else self._take(outcome, self.request)

    def terminate(self, new_status: Status) -> None:
        if self.status == Status.RUNNING and new_status == Status.INVALID:
            if self.unknown is not None:
                self.unknown.withdraw()
            elif self.request is not None:
                self.dispatcher.withdraw(self.request)

    # --- starting

    def _arguments(self) -> dict[str, Any]:
        given = self.plan.arguments.evaluate(self._names("with"))
        return resolve_arguments(
            self.plan.action, given, self.plan.role.limits, label=self.plan.label
        )

    def _names(self, key: str) -> Mapping[str, Any]:
        attempt = self.scope.frame.attempts.get(self.path, 0) + 1
        return self.run.names(self.scope.frame.names, f"{self.path}/{attempt}/{key}")

    def _timeout(self, arguments: dict[str, Any]) -> float | None:
        if self.plan.timeout_s is not None:
            return seconds(self.plan.timeout_s.evaluate(self._names("timeout")))
        return self.plan.action.hung_after_s(arguments)

    def _begin(
        self, arguments: dict[str, Any], timeout_s: float | None, *, surely: bool = False
    ) -> None:
        attempt, past = self._attempt(arguments)
        self.request = request = Request(
            goal_id=f"{self.run.id}/{self.path}/{attempt}", path=self.path, role=self.plan.role,
            action_name=self.plan.action_name, action=self.plan.action, params=arguments,
            timeout_s=timeout_s, within=self.scope.frame.owner.path, adopt=past,
            epoch=past.sent.epoch if past else 0, urgent=self.scope.frame.urgent,
            reservation=self.scope.frame.reservation, strand=self.scope.frame.strand,
        )  # fmt: skip
        if past is None:
            doubtful = self.plan.role.device in self.run.history.doubtful
            request.doubted = doubtful and self.plan.action.effect == "once" and not surely
            self._do(request)
        elif past.ended is None:
            self._ask_about(request, past)
        elif self.earlier.must_not_be_done_anew(past, request.means()):
            said = changed_words(past, arguments)
            self.failure = replace(self._failure("Rejected", said, "yes"), stop=True)
        else:
            request.outcome, request.expired = outcome_of(past), past.expired
            self.dispatcher.replayed(request, past)

    def _attempt(self, arguments: dict[str, Any]) -> tuple[int, PastGoal | None]:
        """The number of this attempt, and what an earlier session has done under it."""
        frame = self.scope.frame
        while True:
            attempt = frame.next_attempt(self.path)
            past = self.earlier.attempt(self.path, attempt)
            if past is None:
                return attempt, None
            if self.replaying and self.run.history.is_replaced(past):
                return attempt, past
            wanted = means(self.plan.role, self.plan.action_name, arguments)
            if not (
                self.earlier.is_behind(past, wanted)
                or self.earlier.others_came(past, frame.strand or frame.owner.path)
            ):
                return attempt, past
            if past.succeeded:
                frame.owner.repeats = True

    def _do(self, request: Request) -> None:
        """Request it; in a replay only what had once succeeded, to set it again."""
        if self.replaying and self.run.past.newest_success(self.path) is None:
            self.failure = came_to_here(self.path)
            return
        self.repeating = self.replaying
        self.dispatcher.request(request)

    def _ask_about(self, request: Request, past: PastGoal) -> None:
        """What it became of a goal that was under way is asked for, as it was sent."""
        if not self.run.past.comparing:
            request.params = past.sent.params
        self.dispatcher.request(request)

    # --- ending

    def _take(self, outcome: Outcome, request: Request) -> Status:
        if outcome.state == "SUCCEEDED":
            self.result = with_units(outcome.result or {}, self.plan.action.returns)
            return Status.SUCCESS
        if self._lost_for_nothing(outcome, request):
            self._begin(request.params, request.timeout_s)
            self.run.requests.again()
            return Status.RUNNING
        self.failure = replace(self._failure_of(outcome, request), anew=self.repeating)
        if self.failure.once and self.failure.happened == "unknown":
            self.unknown = UnknownFate(
                self.run, self.dispatcher, self.plan.role, request, self.failure,
                self.plan.on_unknown,
            )  # fmt: skip
            self.failure = None
            return self._resolve(self.unknown)
        return Status.FAILURE

    def _lost_for_nothing(self, outcome: Outcome, request: Request) -> bool:
        """True if a server was restarted and the same action may simply be requested again.

        Also if the server knows that it was, from a part of the journal that this run has lost. That is
        not a failure: it does not count against the retries. A server that keeps dying is a failure,
        and goes up the ladder as `Lost`.
        """
        error = outcome.error
        if outcome.state not in ("ABORTED", "CANCELED") or request.expired or request.withdrawn:
            return False
        if error is None or error.name not in ("Lost", "NEVER_STARTED"):
            return False
        if self.plan.action.effect == "once" and error.happened != "no":
            return False
        self.lost += 1
        return self.lost <= self.plan.lost_at_most

    def _lost_and_not_done(self, unknown: UnknownFate, verdict: Verdict) -> bool:
        """Lost with its server, and the device reports that it did not happen: unfinished, not failed."""
        name = unknown.failure.name
        if verdict.skip or verdict.stop or name not in ("Lost", "Stopped", "Canceled"):
            return False
        self.lost += 1
        return self.lost <= LOST_AT_MOST

    def _failure_of(self, outcome: Outcome, request: Request) -> Failure:
        error = outcome.error
        name = error.name if error else outcome.state.capitalize()
        happened = error.happened if error else "unknown"
        message = error.message if error else f"{self.plan.label} ended {outcome.state}"
        if name in self.plan.action.errors and happened == "unknown":
            happened = self.plan.action.happened(name)
        elif error is not None and name not in self.plan.action.errors and not _reserved(name):
            message = f"{message} (an error that {self.plan.role.contract.type} does not declare)"
        if request.expired:
            name = "Timeout"
            message = f"{self.plan.label} took longer than {request.timeout_s:g} s"
        return self._failure(name, message, happened)

    def _failure(self, name: str, message: str, happened: Happened) -> Failure:
        return Failure(
            name, message, step=self.path, device=self.plan.role.device, action=self.plan.label,
            happened=happened, once=self.plan.action.effect == "once",
        )  # fmt: skip

    def _resolve(self, unknown: UnknownFate) -> Status:
        verdict = unknown.advance()
        if verdict is None:
            return Status.RUNNING
        self.unknown = None
        if verdict.happened:
            self.result = with_units(verdict.result or {}, self.plan.action.returns)
            return Status.SUCCESS
        if verdict.repeat or self._lost_and_not_done(unknown, verdict):
            request = unknown.request
            if not (request.strand or request.role.contract.concurrent):
                # What follows on this device would have come later still.
                self.run.history.doubtful.discard(request.device)
            self._begin(request.params, request.timeout_s, surely=True)
            self.run.requests.again()
            return Status.RUNNING
        return self.fail(
            replace(unknown.failure, happened="no", skip=verdict.skip, stop=verdict.stop)
        )


OUR_ERRORS = ("Fault", "Canceled", "DiskFull", "Stopped", "NEVER_STARTED")
"""Names that the protocol with servers itself uses, besides those reserved for every action."""


def _reserved(name: str) -> bool:
    return name in RESERVED_ERRORS or name in OUR_ERRORS
