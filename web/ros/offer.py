"""What the lab offers to ROS, whichever face shows it: actions, services and topics under their names."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

from .kinds import ActionKind, Message, ServiceKind
from .values import to_ros

Values = dict[str, Any]
"""A message as field name -> value; see `values.py`."""


class Refused(Exception):
    """A goal, or a call, that is not begun, with the reason in words."""


@dataclass(frozen=True, slots=True)
class End:
    """How a goal ended, with every field of its result."""

    state: Literal["SUCCEEDED", "CANCELED", "ABORTED"]
    result: Values


@dataclass(slots=True)
class Work:
    """One goal, as the action that does it sees it."""

    id: str
    values: Values
    tell: Callable[[Values], None]
    """Feedback for whoever asked."""
    begun: asyncio.Event = field(default_factory=asyncio.Event)
    """Set by the action when it has taken the goal: before that it may refuse it."""
    cancelled: asyncio.Event = field(default_factory=asyncio.Event)
    """Set when a client wants the goal cancelled."""


class Action(ABC):
    """Something that takes time: a device's action, a protocol run, one of the paper's names."""

    name: str
    kind: ActionKind
    can_cancel: bool = True
    close_s: float = 5.0
    """How long its goals are waited for when the lab is offered no more."""

    @abstractmethod
    async def carry(self, work: Work) -> End:
        """Do it; raises Refused before `begun` is set, and nothing after it."""


class Service(ABC):
    """Something that is answered once."""

    name: str
    kind: ServiceKind

    @abstractmethod
    async def answer(self, values: Values) -> Values:
        """Every field of the response; raises Refused."""

    def refused(self, words: str) -> Values:
        """The response that says why there is none, for clients that know no other way."""
        said = {
            "@error_name": "Rejected",
            "@error_message": words,
            "@error_happened": "no",
            "message": words,
        }
        return to_ros(self.kind.response, said)


class Topic:
    """Something that is told again and again; `latest` is what a new listener hears at once."""

    def __init__(self, name: str, kind: Message) -> None:
        self.name = name
        self.kind = kind
        self.latest: Values | None = None
        self._listeners: set[Callable[[Values], None]] = set()

    def publish(self, values: Values) -> None:
        """Tell all who listen."""
        self.latest = values
        for listener in list(self._listeners):
            listener(values)

    def listen(self, listener: Callable[[Values], None]) -> None:
        """Be told from now on, and at once what was told last."""
        self._listeners.add(listener)
        if self.latest is not None:
            listener(self.latest)

    def leave(self, listener: Callable[[Values], None]) -> None:
        """Be told no more."""
        self._listeners.discard(listener)


@dataclass(slots=True)
class Offers:
    """All of them, by name; a name stands for one action, one service and one topic at most."""

    actions: dict[str, Action] = field(default_factory=dict)
    services: dict[str, Service] = field(default_factory=dict)
    topics: dict[str, Topic] = field(default_factory=dict)
