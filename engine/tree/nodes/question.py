"""A person is asked: `confirm` wants a yes, `ask` one of its choices."""

from py_trees.common import Status

from ...language.expression import ExpressionError
from ...language.value import Value, as_text
from ...run.frame import Scope
from ...run.questions import REFUSALS, Question
from ...run.run import Run
from .failure import Failure
from .node import Node
from .replay_failed import came_to_here


class AskPerson(Node):
    """Waits for an answer from the terminal, the page, another shell, or one given in advance."""

    def __init__(
        self, segment: str, run: Run, scope: Scope, text: Value, choices: list[str],
        *, question_id: str, confirm: bool,
    ) -> None:  # fmt: skip
        super().__init__(segment, run)
        self.scope = scope
        self.text = text
        self.choices = choices
        self.question_id = question_id
        self.confirm = confirm
        self.question: Question | None = None

    def initialise(self) -> None:
        self.question = None
        path = f"{self.scope.frame.path}/{self.name}"
        try:
            text = as_text(self.text.evaluate(self.run.names(self.scope.frame.names, path)))
        except ExpressionError as fault:
            self.failure = Failure("Expression", str(fault), step=path)
            return
        if self.replaying and path not in self.run.past.answers:
            self.failure = came_to_here(path)
            return
        self.question = self.run.ask(
            Question(path=path, id=self.question_id, text=text, choices=list(self.choices)),
            confirm=self.confirm,
        )

    def update(self) -> Status:
        if self.question is None:
            return Status.FAILURE
        if self.question.choice is None:
            return Status.RUNNING
        self.run.answered(self.question)
        self.result = {"choice": self.question.choice}
        if self.confirm and self.question.choice in REFUSALS:
            message = f"answered {self.question.choice!r} by {self.question.by}"
            return self.fail(Failure("Refused", message, step=self.question.path, stop=True))
        return Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        if self.status == Status.RUNNING and new_status == Status.INVALID and self.question:
            self.run.questions.close(self.question.path)
