"""What the driver needs from ROS, whichever connection it uses."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

Values = dict[str, Any]
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
"""Numbers of action_msgs/msg/GoalStatus."""


class Rejected(Exception):
    """The action server rejected the goal, or there is none; nothing happened."""


class Gone(OSError):
    """The connection to ROS is broken; the outcome of its goals is unknown."""


@dataclass(slots=True)
class Sent:
    """A goal under way; `ended` holds its status and result, or Rejected or Gone."""

    ended: "asyncio.Future[tuple[int, Values]]"
    cancel: Callable[[], None]


class Bridge(ABC):
    """A connection to a ROS system; its callbacks run in the event loop."""

    @abstractmethod
    async def open(self) -> None:
        """Connect to ROS; raises Gone."""

    @abstractmethod
    async def close(self) -> None:
        """Disconnect."""

    @property
    @abstractmethod
    def connected(self) -> bool:
        """Whether it is connected now."""

    @abstractmethod
    async def send(
        self, action: str, type: str, goal: Values, feedback: Callable[[Values], None], id: bytes
    ) -> Sent:
        """Send a goal; raises Gone, and Rejected if it does not fit the type.

        `id` is its sixteen bytes in ROS where the connection can choose it.
        """

    @abstractmethod
    async def call(self, service: str, type: str, request: Values) -> Values:
        """Call a service; raises as `send` does."""

    @abstractmethod
    async def cancel_left(self, action: str, id: bytes) -> None:
        """Cancel a goal that an earlier session of the driver left behind; raises Gone.

        Where the connection could not choose its id: every goal of the action. Returns when that was
        answered, or when there is no server that could be doing it.
        """

    @abstractmethod
    async def serves(self, action: str, type: str) -> bool:
        """Whether a server of the action is there; True where that cannot be known."""

    @abstractmethod
    def listen(
        self, topic: str, type: str, heard: Callable[[Values], None], qos: dict[str, Any]
    ) -> None:
        """Subscribe to a topic; raises Gone."""


def resolve(future: "asyncio.Future[Any]", said: Any) -> None:
    """Its answer, or the exception that stands for it, unless it has one."""
    if future.done():
        return
    if isinstance(said, Exception):
        future.set_exception(said)
    else:
        future.set_result(said)
