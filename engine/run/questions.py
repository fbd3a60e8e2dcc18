"""Questions to a person: asked by `confirm` and `ask`, answered from anywhere."""

from collections.abc import Callable
from dataclasses import dataclass

REFUSALS = ("no", "stop")


@dataclass(slots=True)
class Question:
    """One open question; `choice` is None until it is answered."""

    path: str
    id: str
    text: str
    choices: list[str]
    choice: str | None = None
    by: str = ""


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
            question.choice, question.by = given, "--answer"
        elif confirm and self.yes:
            question.choice, question.by = "yes", "--yes"
        elif self.person is not None:
            question.choice, question.by = self.person(question), "rehearsal"

    def answer(self, name: str, choice: str, by: str) -> Question:
        """Answer the open question of this id or path; raises WrongAnswer with a sentence."""
        found = [q for q in self.open.values() if q.choice is None and name in (q.id, q.path)]
        if not found:
            ids = ", ".join(q.id for q in self.open.values() if q.choice is None)
            raise WrongAnswer(
                f"no question {name!r} is open; " + (f"open: {ids}" if ids else "none is open")
            )
        question = found[0]
        if choice not in question.choices:
            raise WrongAnswer(
                f"{choice!r} is not a choice of {question.id!r}; choose {', '.join(question.choices)}"
            )
        question.choice, question.by = choice, by
        self.changed()
        return question

    def close(self, path: str) -> None:
        """Withdraw a question, answered or not."""
        self.open.pop(path, None)
