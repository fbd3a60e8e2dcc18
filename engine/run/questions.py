"""Questions to a person: asked by `confirm` and `ask`, answered from anywhere."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

REFUSALS = ("no", "stop")
HAPPENED, DID_NOT_HAPPEN = "happened", "did_not_happen"
"""What a person says who knows it, of an action whose fate no device could tell."""


@dataclass(slots=True)
class Question:
    """One open question; `choice` is None until it is answered.

    With the choice HAPPENED go values: `wants` is their JSON schema, `takes` checks what a person
    gives, and `result` is what they are then.
    """

    path: str
    id: str
    text: str
    choices: list[str]
    choice: str | None = None
    by: str = ""
    wants: dict[str, Any] = field(default_factory=dict)
    takes: Callable[[Mapping[str, str]], dict[str, Any]] | None = None
    result: dict[str, Any] | None = None

    def answer(self, choice: str, by: str, values: Mapping[str, str]) -> None:
        """Take an answer; raises WrongAnswer with a sentence."""
        if choice not in self.choices:
            raise WrongAnswer(
                f"{choice!r} is not a choice of {self.id!r}; choose {', '.join(self.choices)}"
            )
        if choice == HAPPENED and self.takes is not None:
            self.result = self.takes(values)
        elif values:
            raise WrongAnswer(f"{choice!r} takes no values: {', '.join(values)}")
        self.choice, self.by = choice, by


class WrongAnswer(ValueError):
    """An answer to a question that is not open, or a choice that it does not offer."""


class Questions:
    """The open questions of a run, and the answers given in advance (`--yes`, `--answer`).

    `person` answers at once, in a rehearsal.
    """

    def __init__(
        self, *, yes: bool = False, answers: dict[str, str] | None = None,
        changed: Callable[[], None] = lambda: None,
    ) -> None:  # fmt: skip
        self.person: Callable[[Question], str] | None = None
        self.yes = yes
        self.answers = answers or {}
        self.changed = changed
        self.open: dict[str, Question] = {}

    def ask(self, question: Question, *, confirm: bool) -> None:
        """Open a question; one that was answered in advance is answered at once."""
        self.open[question.path] = question
        given = self.answers.get(question.id)
        if given in question.choices:
            with suppress(WrongAnswer):  # it needs values: then it stays open
                question.answer(given, "--answer", {})
        elif confirm and self.yes:
            question.choice, question.by = "yes", "--yes"
        elif self.person is not None:
            question.choice, question.by = self.person(question), "rehearsal"

    def answer(
        self, name: str, choice: str, by: str, values: Mapping[str, str] | None = None
    ) -> Question:
        """Answer the open question of this id or path; raises WrongAnswer with a sentence."""
        found = [q for q in self.open.values() if q.choice is None and name in (q.id, q.path)]
        if not found:
            ids = ", ".join(q.id for q in self.open.values() if q.choice is None)
            raise WrongAnswer(
                f"no question {name!r} is open; " + (f"open: {ids}" if ids else "none is open")
            )
        question = found[0]
        question.answer(choice, by, values or {})
        self.changed()
        return question

    def close(self, path: str) -> None:
        """Withdraw a question, answered or not."""
        self.open.pop(path, None)
