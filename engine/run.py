"""One run: what every node of its tree needs to know and to reach."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour

from ..schemas import journal as j
from ..schemas.event import Event, EventKind
from .bind import BoundRole
from .clock import RunClock
from .encode import encode
from .frame import Frame, Scope
from .history import History
from .journal import Journal
from .questions import Question, Questions


@dataclass(slots=True)
class CutOff:
    """The `finally` of a used protocol, for the end of the run where its own never came.

    `finals`: how often it was begun before; each time has a path, and so ids, of its own.
    """

    build: Callable[[Scope], Behaviour]
    names: dict[str, Any]
    frame: Frame
    finals: int = 0


Listener = Callable[[Event], None]
"""Whoever watches a run; it is told, and nothing of the run depends on it."""


@dataclass(slots=True)
class Run:
    """The state that belongs to a whole run. Nodes ask for another tick by `again` or `wake_at`."""

    id: str
    folder: Path
    journal: Journal
    history: History
    roles: Mapping[str, BoundRole]
    params: Mapping[str, Any]
    about: dict[str, Any]
    questions: Questions
    clock: RunClock = field(default_factory=RunClock)
    listeners: list[Listener] = field(default_factory=list)
    holes: int = 0
    pause_wanted: str = ""
    taken_up: bool = False
    """True when the run is to go on from its journal: a failed step is tried again after a pause."""
    repeated: set[str] = field(default_factory=set)
    """Paths of iterations and phases in which finished steps are done again, their device touched."""
    cut_off: dict[str, CutOff] = field(default_factory=dict)
    """By path, the used protocols that were entered and have not come to the end of their `finally`."""
    bygone: bool = False
    """True while what has failed in an earlier life is gone through once more: see nodes/bygone.py."""
    _again: bool = False
    _wake_at: float | None = None

    def again(self) -> None:
        """Tick once more before waiting: something changed that no event will tell."""
        self._again = True

    def wake_at(self, when: float) -> None:
        """Tick at this time of the run's clock at the latest."""
        if self._wake_at is None or when < self._wake_at:
            self._wake_at = when

    def take_round(self) -> tuple[bool, float | None]:
        """Whether another tick was asked for, and by when; both are reset."""
        asked = self._again, self._wake_at
        self._again, self._wake_at = False, None
        return asked

    def record(self, record: j.Record) -> int:
        """Put a record into the journal; durable with the next flush."""
        return self.journal.append(record)

    def tell(
        self, event: EventKind, path: str = "", state: str = "", text: str = "", **data: Any
    ) -> None:
        """Let those who watch know; nothing of the run depends on it."""
        if self.listeners:
            at = datetime.now(UTC).isoformat(timespec="milliseconds")
            told = Event(
                event=event, at=at, path=path, state=state, text=text, data=encode(data)
            )  # fmt: skip
            for listener in self.listeners:
                listener(told)

    def log(self, text: str, path: str = "") -> None:
        """A line for the screen."""
        self.tell("log", path, text=text)

    def ask(self, question: Question, *, confirm: bool = False) -> Question:
        """Ask a person; an answer that the journal holds from before is the answer."""
        past = self.history.answers.get(question.path)
        if past is not None and past.choice in question.choices:
            question.choice, question.by = past.choice, past.by
            return question
        self.record(
            j.Asked(
                path=question.path, id=question.id, text=question.text, choices=question.choices
            )
        )
        self.questions.ask(question, confirm=confirm)
        self.tell(
            "question", question.path, "open" if question.choice is None else "answered",
            question.text, id=question.id, choices=question.choices, confirm=confirm,
        )  # fmt: skip
        return question

    def answered(self, question: Question) -> None:
        """Note an answer in the journal and close its question."""
        if question.path in self.questions.open:
            self.record(
                j.Answered(path=question.path, choice=question.choice or "", by=question.by)
            )
            self.questions.close(question.path)
            self.tell("answer", question.path, question.choice or "", by=question.by)
