"""When nobody knows whether a `once` action happened: probe the device, then ask a person.

A contract's probe is a pure action that tells the newest doing of the thing and the goal that asked
for it, in the result `goal_id`. Ours: it happened, and the probe's other fields are the result.
Another's, or empty for a device that surely never did it: it did not happen. Null, for a device that
does not remember who asked, or no answer: a person decides.
"""

from dataclasses import dataclass
from typing import Any

from ..bind import BoundRole
from ..dispatcher import Dispatcher
from ..failure import Failure
from ..questions import Question
from ..request import Request
from ..run import Run

PROBE_TIMEOUT_S = 60.0
CHOICES = ["repeat", "skip", "stop"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What is taken as true, and what to do about it."""

    happened: bool = False
    result: dict[str, Any] | None = None
    repeat: bool = False
    skip: bool = False
    stop: bool = False


class UnknownFate:
    """Finds out, one question after the other, without ever guessing."""

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
        self.question: Question | None = None
        self.verdict: Verdict | None = None
        run.tell("goal", request.path, "unknown", failure.sentence())
        self._start(policy)

    def advance(self) -> Verdict | None:
        """The verdict, or None while it is still being found."""
        if self.verdict is None and self.probe is not None and self.probe.outcome is not None:
            self.verdict = self._read_probe(self.probe)
            self.probe = None
            if self.verdict is None:
                self._ask()
        if self.verdict is None and self.question is not None and self.question.choice:
            choice = self.question.choice
            self.run.answered(self.question)
            self.verdict = Verdict(
                repeat=choice == "repeat", skip=choice == "skip", stop=choice == "stop"
            )
        return self.verdict

    def withdraw(self) -> None:
        """Stop asking: the step is being stopped."""
        if self.probe is not None:
            self.dispatcher.withdraw(self.probe)
        if self.question is not None:
            self.run.questions.close(self.question.path)

    def _start(self, policy: str) -> None:
        if policy == "probe" and self.request.action.probe:
            self._send_probe(self.request.action.probe)
        elif policy == "repeat":
            self.verdict = Verdict(repeat=True)
        elif policy == "skip":
            self.verdict = Verdict(skip=True)
        else:
            self._ask()

    def _send_probe(self, name: str) -> None:
        path = f"{self.request.goal_id.partition('/')[2]}/probe"
        history = self.run.history
        attempt = 1
        while (past := history.goal(path, attempt)) is not None and not (
            past.ended and past.ended.state == "SUCCEEDED"
        ):
            attempt += 1
        self.probe = Request(
            goal_id=f"{self.run.id}/{path}/{attempt}", path=path, role=self.role,
            action_name=name, action=self.role.contract.actions[name], params={},
            timeout_s=PROBE_TIMEOUT_S,
        )  # fmt: skip
        if past is not None and past.ended is not None:
            from .action import _outcome_of

            self.probe.outcome = _outcome_of(past)
        else:
            self.dispatcher.request(self.probe)

    def _read_probe(self, probe: Request) -> Verdict | None:
        assert probe.outcome is not None
        told = probe.outcome.result
        if probe.outcome.state != "SUCCEEDED" or told is None or "goal_id" not in told:
            return None
        if told["goal_id"] == self.request.goal_id:
            wanted = self.request.action.returns.get("properties", {})
            return Verdict(happened=True, result={k: v for k, v in told.items() if k in wanted})
        if told["goal_id"] is None:
            return None  # a device without a memory of it proves nothing
        return Verdict()

    def _ask(self) -> None:
        self.question = self.run.ask(
            Question(
                path=f"{self.request.goal_id.partition('/')[2]}/unknown",
                id=self.request.path.rpartition("/")[2],
                text=(
                    f"Nobody knows whether {self.request.label} happened "
                    f"({self.failure.name}: {self.failure.message}). Look at the device. "
                    "Do it again, skip this point, or stop the run?"
                ),
                choices=list(CHOICES),
            )
        )
