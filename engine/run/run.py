"""One run: what every node of its tree needs."""

import logging
from collections import ChainMap
from collections.abc import Awaitable, Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import Any

from ...schemas import journal as j
from ...schemas.event import KINDS, Event, EventKind
from ...schemas.quantity import quantity
from ..journal.encode import decode, encode
from ..journal.history import History
from ..journal.journal import Journal
from ..journal.past import Past
from ..lab.bind import BoundRole
from ..language.expression import STATUS
from ..language.own_functions import OwnFunction
from .clock import RunClock
from .finals import DueFinals
from .function_calls import call
from .open_uses import OpenUse
from .questions import Question, Questions
from .requests import Requests
from .strands import Strands


class RecordedStatus(Mapping[str, Any]):
    """`status` in expressions: what each role's device told, kept in the journal where it was read."""

    def __init__(self, run: "Run", place: str) -> None:
        self.run, self.place = run, place

    def __getitem__(self, role: str) -> Any:
        if role not in self.run.roles:
            raise KeyError(role)
        return self.run.computed(f"{self.place}/status:{role}", lambda: self.run.told(role))

    def __iter__(self) -> Iterator[str]:
        return iter(self.run.roles)

    def __len__(self) -> int:
        return len(self.run.roles)


LOG = logging.getLogger("labrun")
Listener = Callable[[Event], None]
"""A watcher of a run: it is notified, and the run does not depend on it."""


@dataclass(slots=True)
class Run:
    """The state that belongs to a whole run."""

    id: str
    folder: Path
    journal: Journal
    history: History
    """All that has happened, also in this session; only `record` adds to it."""
    roles: Mapping[str, BoundRole]
    params: Mapping[str, Any]
    about: dict[str, Any]
    questions: Questions
    clock: RunClock = field(default_factory=RunClock)
    past: Past = field(default_factory=Past)
    """What the tree under way found done when it was planted."""
    listeners: dict[EventKind, tuple[Listener, ...]] = field(default_factory=dict)
    """Of what kind of event anybody is told, and who."""
    requests: Requests = field(default_factory=Requests)
    finals: DueFinals = field(default_factory=DueFinals)
    open_uses: dict[str, OpenUse] = field(default_factory=dict)
    """Used protocols with an `on_resume` that are under way, by path, in the order of entering."""
    left_undone: dict[str, str] = field(default_factory=dict)
    """Steps of a `finally` that have failed with `on_error: continue`: path -> what happened."""
    strands: Strands = field(default_factory=Strands)

    call: Callable[[OwnFunction, dict[str, Any], float], Awaitable[Any]] = call
    """How a function of a protocol's own is called."""
    calling: list[str] = field(default_factory=list)
    """Names of those that are being called."""
    turns_at_most: int | None = None
    """In a rehearsal, of a `while` without `max`: what it waits for may never come there."""
    asks_clocks: bool = False
    """Whether any expression of its protocols asks a clock."""

    watches_changes: bool = False
    """Whether any of its steps is watched on change, and not only every so often."""
    told: Callable[[str], Any] = lambda role: None
    """What the device of a role has told of itself, with units."""
    notify: Callable[[str, str], None] = lambda text, picture: None
    """Sends a message to the people whom the lab names, with a picture of the run."""

    def names(self, names: ChainMap[str, Any], place: str) -> ChainMap[str, Any]:
        """The names of a frame with the clocks, for the expressions of one place in the run."""
        if not self.asks_clocks:
            return names
        asked = count(1)

        def now() -> datetime:
            return self.computed(f"{place}/now:{next(asked)}", self.clock.time_of_day)

        def elapsed() -> Any:
            return self.computed(f"{place}/elapsed:{next(asked)}", self.elapsed)

        own: dict[str, Any] = {"now()": now, "elapsed()": elapsed}
        if STATUS not in names:
            own[STATUS] = RecordedStatus(self, place)
        return names.new_child(own)

    def computed(self, path: str, compute: Callable[[], Any]) -> Any:
        """What a clock says; where it was asked before the engine was killed, what it said then."""
        known = self.history.past.computed
        if path not in known:
            self.record(j.Computed(path=path, value=encode(compute())))
        return decode(known[path])

    def elapsed(self) -> Any:
        """The time since the run's steps began; a clock that is set in this session makes no difference."""
        assert self.history.started is not None
        began = datetime.fromisoformat(self.history.main_at or self.history.started.at)
        return quantity(round(max(0.0, self.clock.since(began)), 3), "s")

    def record(self, record: j.Record) -> None:
        """Put a record into the journal, durable with the next flush, and learn what it says."""
        self.history.take(self.journal.append(record))

    def listen(self, listener: Listener, kinds: Collection[EventKind] = KINDS) -> None:
        """Tell a watcher from now on what happens of these kinds."""
        for kind in kinds:
            self.listeners[kind] = (*self.listeners.get(kind, ()), listener)

    def unlisten(self, listener: Listener) -> None:
        """Tell a watcher nothing more."""
        for kind, told in list(self.listeners.items()):
            if left := tuple(one for one in told if one != listener):
                self.listeners[kind] = left
            else:
                del self.listeners[kind]

    def is_heard(self, event: EventKind) -> bool:
        """Whether a watcher wants events of this kind."""
        return event in self.listeners

    def tell(
        self, event: EventKind, path: str = "", state: str = "", text: str = "", **data: Any
    ) -> None:
        """Notify the watchers; the run does not depend on it."""
        if listeners := self.listeners.get(event):
            at = datetime.now(UTC).isoformat(timespec="milliseconds")
            told = Event(
                event=event, at=at, path=path, state=state, text=text, data=encode(data)
            )  # fmt: skip
            for listener in listeners:
                self._hear(listener, told)

    def _hear(self, listener: Listener, told: Event) -> None:
        try:
            listener(told)
            return
        except BrokenPipeError:  # `| head`: whoever read has gone, and that is no fault
            pass
        except Exception:  # whatever is wrong with a watcher, nothing of the run depends on it
            LOG.exception("a watcher of the run failed at %r; it hears nothing more", told.event)
        self.unlisten(listener)

    def log(self, text: str, path: str = "") -> None:
        """A line for the screen."""
        self.tell("log", path, text=text)

    def ask(self, question: Question, *, confirm: bool = False) -> Question:
        """Ask a person; an earlier answer in the journal is used."""
        past = self.past.answers.get(question.path)
        if past is not None and past.choice in question.choices:
            question.choice, question.by, question.result = past.choice, past.by, past.result
            return question
        self.record(
            j.Asked(
                path=question.path, id=question.id, text=question.text, choices=question.choices,
                wants=question.wants,
            )
        )  # fmt: skip
        self.questions.ask(question, confirm=confirm)
        self.tell(
            "question", question.path, "open" if question.choice is None else "answered",
            question.text, id=question.id, choices=question.choices, confirm=confirm,
            wants=question.wants,
        )  # fmt: skip
        return question

    def answered(self, question: Question) -> None:
        """Note an answer in the journal and close its question."""
        if question.path in self.questions.open:
            self.record(
                j.Answered(
                    path=question.path, choice=question.choice or "", by=question.by,
                    result=question.result,
                )
            )  # fmt: skip
            self.questions.close(question.path)
            self.tell("answer", question.path, question.choice or "", by=question.by)
