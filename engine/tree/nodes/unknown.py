"""When it is not known whether a `once` action happened: probe the device, then ask a person.

A probe that its server refuses, since its disk is full or the device is being made safe, has said
nothing. It is asked again for as long as `start_timeout`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ....drivers.client.client import Outcome
from ...dispatch.dispatcher import Dispatcher
from ...dispatch.probe import probe_request, told_before, told_by, unknown_path, what_it_proves
from ...dispatch.request import Request
from ...lab.bind import BoundRole
from ...language.arguments import ArgumentFaults, resolve_arguments, typed
from ...run.questions import DID_NOT_HAPPEN, HAPPENED, Question, WrongAnswer
from ...run.run import Run
from .failure import Failure

PROBE_AGAIN_S = 2.0
"""How long after a refused probe the next is sent."""
CHOICES = ["repeat", "skip", "stop", HAPPENED, DID_NOT_HAPPEN]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What is assumed to be true, and what to do about it."""

    happened: bool = False
    result: dict[str, Any] | None = None
    repeat: bool = False
    skip: bool = False
    stop: bool = False


class UnknownFate:
    """Finds out by one question after another, without guessing."""

    def __init__(
        self, run: Run, dispatcher: Dispatcher, role: BoundRole, request: Request,
        failure: Failure, policy: str,
    ) -> None:  # fmt: skip
        self.run = run
        self.dispatcher = dispatcher
        self.role = role
        self.request = request
        self.failure = failure
        self.probe: Request | None = None
        self.probe_again_at: float | None = None
        self.probe_until: float | None = None
        self.refused = ""
        self.question: Question | None = None
        self.verdict: Verdict | None = None
        run.tell("goal", request.path, "unknown", failure.sentence())
        self._start(policy)

    def advance(self) -> Verdict | None:
        """The verdict, or None while it is not yet known."""
        if self.verdict is None and self.probe is not None and self.probe.outcome is not None:
            outcome, self.probe = self.probe.outcome, None
            self.verdict = self._read(told_by(outcome))
            if self.verdict is None and not self._asks_again(outcome):
                self._ask()
        if self.probe_again_at is not None:
            if self.run.clock.now() < self.probe_again_at:
                self.run.requests.wake_at(self.probe_again_at)  # whatever the tick was for
                return None
            self.probe_again_at = None
            self._send_probe()
        if self.verdict is None and self.question is not None and self.question.choice:
            choice, result = self.question.choice, self.question.result
            self.run.answered(self.question)
            self.verdict = Verdict(
                happened=choice == HAPPENED, result=result,
                repeat=choice == "repeat", skip=choice == "skip", stop=choice == "stop",
            )  # fmt: skip
        return self.verdict

    def withdraw(self) -> None:
        """Stop asking: the step is being stopped."""
        if self.probe is not None:
            self.dispatcher.withdraw(self.probe)
        if self.question is not None:
            self.run.questions.close(self.question.path)

    def _start(self, policy: str) -> None:
        if policy == "probe" and self.request.action.probe:
            self._send_probe()
        elif policy == "repeat":
            self.verdict = Verdict(repeat=True)
        elif policy == "skip":
            self.verdict = Verdict(skip=True)
        else:
            self._ask()

    def _send_probe(self) -> None:
        goal_id, history = self.request.goal_id, self.run.history
        told = told_before(history, goal_id)
        if unknown_path(goal_id) in self.run.past.answers:
            self._ask()  # a person has already answered
            return
        if told is not None:
            self.verdict = self._read(told)
        else:
            self.probe = probe_request(history, self.role, goal_id, self.request.action_name)
        if self.probe is not None:
            self.probe.reservation = self.request.reservation
            self.dispatcher.request(self.probe, first=True)
        elif self.verdict is None:
            self._ask()

    def _asks_again(self, outcome: Outcome) -> bool:
        """Whether a probe was refused, and its server may have room for it in a moment."""
        error, now = outcome.error, self.run.clock.now()
        if error is None or error.name not in ("Rejected", "Busy"):
            return False
        self.refused = f" Its probe was refused: {error.message}."
        if self.probe_until is None:
            limit_s = self.dispatcher.out_of_touch_s
            self.probe_until = now + limit_s
            self.run.log(
                f"it is not known yet whether {self.request.label} happened: its probe was refused "
                f"({error.message}); it is asked again for {limit_s:g} s (`start_timeout`)",
                self.request.path,
            )
        if now >= self.probe_until:
            return False
        self.probe_again_at = min(now + PROBE_AGAIN_S, self.probe_until)
        return True

    def _read(self, told: dict[str, Any] | None) -> Verdict | None:
        request = self.request
        happened = what_it_proves(self.run.history, self.role, request.goal_id, told)
        if not happened:
            return None if happened is None else Verdict()
        wanted = request.action.returns.get("properties", {})
        return Verdict(happened=True, result={k: v for k, v in (told or {}).items() if k in wanted})

    def _ask(self) -> None:
        self.question = self.run.ask(
            Question(
                path=unknown_path(self.request.goal_id),
                id=self.request.path.rpartition("/")[2],
                text=(
                    f"It is not known whether {self.request.label} happened "
                    f"({self.failure.name}: {self.failure.message}).{self.refused} Look at the device: "
                    "did it happen? If nobody can tell: do it again, skip this point, or stop the run?"
                ),
                choices=list(CHOICES),
                wants=self.request.action.returns,
                takes=self._returned,
            )
        )

    def _returned(self, values: Mapping[str, str]) -> dict[str, Any]:
        """What the action returned, by a person's word; raises WrongAnswer with what is wrong."""
        action = self.request.action.model_copy(update={"params": self.request.action.returns})
        schemas = action.param_schemas()
        given = {name: typed(text, schemas.get(name, {})) for name, text in values.items()}
        try:
            return resolve_arguments(action, given, {}, label=f"{self.request.label} returned")
        except ArgumentFaults as fault:
            raise WrongAnswer(str(fault).strip()) from None
