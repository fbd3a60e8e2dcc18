"""What ROS calls interfaces: messages of fields, actions of three messages, services of two."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

PACKAGE = "labrun_interfaces"


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message.

    `key` is its name in the contract. `array` is what ROS writes behind the type: `[]`, `[3]`,
    `[<=3]` or nothing. `optional`: a list of at most one stands for a value that may be left out,
    since ROS knows no value that is not there. `json`: free-form data as text. `constants` are the
    words that it may hold.
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
        """Its type as a `.msg` file has it."""
        bound = f"<={self.bound}" if self.bound is not None else ""
        return f"{self.type}{bound}{self.array}"


@dataclass(frozen=True, slots=True)
class Message:
    """A message; those within an action bear its name and no file of their own."""

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
        """Messages that its fields hold, the innermost first."""
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
        """Goal, result and feedback, as a `.action` file has them."""
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
        """Request and response, as a `.srv` file has them."""
        return (self.request, self.response)


def same_type(asked: object, type: str) -> bool:
    """Whether a client means this type: `pkg/action/Name`, or the short `pkg/Name` of ROS 1."""
    package, _, name = type.split("/")
    return asked in (type, f"{package}/{name}")
