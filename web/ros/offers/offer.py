"""What the lab offers to ROS, by endpoint or node: actions, services and topics by name."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

from ..interfaces.kinds import ActionKind, Message, ServiceKind
from ..interfaces.values import to_ros

Values = dict[str, Any]
"""A message as field name -> value; see `values.py`."""


class Refused(Exception):
    """A goal or call that is not started, with the reason."""


@dataclass(frozen=True, slots=True)
class End:
    """How a goal ended, with every field of its result."""

    state: Literal["SUCCEEDED", "CANCELED", "ABORTED"]
    result: Values


@dataclass(slots=True)
class Work:
    """One goal, as seen by its action."""

    id: str
    values: Values
    tell: Callable[[Values], None]
    """Feedback for the client."""
    begun: asyncio.Event = field(default_factory=asyncio.Event)
    """Set by the action when it has accepted the goal: before that it may refuse it."""
    cancelled: asyncio.Event = field(default_factory=asyncio.Event)
    """Set when a client wants the goal cancelled."""


class Action(ABC):
    """A long operation: a device's action, a protocol run, one of the paper's names."""

    name: str
    kind: ActionKind
    can_cancel: bool = True
    close_s: float = 5.0
    """How long to wait for its goals when the lab is no longer offered."""

    @abstractmethod
    async def carry(self, work: Work) -> End:
        """Do it; raises Refused only before `begun` is set, and nothing after."""


class Service(ABC):
    """A request with one answer."""

    name: str
    kind: ServiceKind

    @abstractmethod
    async def answer(self, values: Values) -> Values:
        """Every field of the response; raises Refused."""

    def refused(self, words: str) -> Values:
        """The response that reports a refusal, for clients without another way to receive it."""
        said = {
            "@error_name": "Rejected",
            "@error_message": words,
            "@error_happened": "no",
            "message": words,
            "response": words,
        }
        return to_ros(self.kind.response, said)


class Topic:
    """A repeated message; a new listener gets `latest` at once."""

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
        """Start listening; the last message comes at once."""
        self._listeners.add(listener)
        if self.latest is not None:
            listener(self.latest)

    def leave(self, listener: Callable[[Values], None]) -> None:
        """Stop listening."""
        self._listeners.discard(listener)


@dataclass(slots=True)
class Offers:
    """All offers by name; a name has at most one action, one service and one topic."""

    actions: dict[str, Action] = field(default_factory=dict)
    services: dict[str, Service] = field(default_factory=dict)
    topics: dict[str, Topic] = field(default_factory=dict)
