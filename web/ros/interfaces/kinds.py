"""ROS interfaces: messages of fields, actions of three messages, services of two."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

PACKAGE = "labrun_interfaces"


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message.

    `key` is its name in the contract. `array` is the ROS suffix of the type: `[]`, `[3]`, `[<=3]` or
    nothing. `optional`: a list of at most one represents an optional value, since ROS has no absent
    values. `json`: free-form data as text. `constants` are the values that it may have.
    """

    name: str
    type: str
    key: str
    array: str = ""
    bound: int | None = None
    default: Any = None
    optional: bool = False
    json: bool = False
    comment: str = ""
    constants: tuple[tuple[str, Any], ...] = ()
    message: "Message | None" = None

    @property
    def written(self) -> str:
        """Its type as in a `.msg` file."""
        bound = f"<={self.bound}" if self.bound is not None else ""
        return f"{self.type}{bound}{self.array}"


@dataclass(frozen=True, slots=True)
class Message:
    """A message; those within an action have its name and no separate file."""

    package: str
    name: str
    fields: tuple[Field, ...] = ()
    summary: str = ""
    group: str = "msg"

    @property
    def type(self) -> str:
        """`labrun_interfaces/msg/GantryStatus`."""
        return f"{self.package}/{self.group}/{self.name}"

    def nested(self) -> Iterator["Message"]:
        """Messages in its fields, the innermost first."""
        for field in self.fields:
            if field.message is not None:
                yield from field.message.nested()
                yield field.message


@dataclass(frozen=True, slots=True)
class ActionKind:
    """The type of an action."""

    package: str
    name: str
    goal: Message
    result: Message
    feedback: Message
    summary: str = ""
    group: str = "action"

    @property
    def type(self) -> str:
        """`labrun_interfaces/action/GantryMoveTo`."""
        return f"{self.package}/{self.group}/{self.name}"

    def parts(self) -> tuple[Message, ...]:
        """Goal, result and feedback, as in a `.action` file."""
        return (self.goal, self.result, self.feedback)


@dataclass(frozen=True, slots=True)
class ServiceKind:
    """The type of a service."""

    package: str
    name: str
    request: Message
    response: Message
    summary: str = ""
    group: str = "srv"

    @property
    def type(self) -> str:
        """`labrun_interfaces/srv/PipetteLastStroke`."""
        return f"{self.package}/{self.group}/{self.name}"

    def parts(self) -> tuple[Message, ...]:
        """Request and response, as in a `.srv` file."""
        return (self.request, self.response)


def same_type(asked: object, type: str) -> bool:
    """Whether a client means this type: `pkg/action/Name`, or the short `pkg/Name` of ROS 1."""
    package, _, name = type.split("/")
    return asked in (type, f"{package}/{name}")
