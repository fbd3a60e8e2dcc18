"""What the driver wants of ROS, whichever way it goes there."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

Values = dict[str, Any]
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
"""Numbers of action_msgs/msg/GoalStatus."""


class Rejected(Exception):
    """The action server did not take the goal, or there is none; nothing happened."""


class Gone(OSError):
    """The way to ROS is broken; what became of a goal nobody can say."""


@dataclass(slots=True)
class Sent:
    """A goal under way; `ended` holds its status and result, or Rejected or Gone."""

    ended: "asyncio.Future[tuple[int, Values]]"
    cancel: Callable[[], None]


class Bridge(ABC):
    """One way to a ROS system; the callbacks that it is given run in the event loop."""

    @abstractmethod
    async def open(self) -> None:
        """Reach ROS; raises Gone."""

    @abstractmethod
    async def close(self) -> None:
        """Leave it."""

    @property
    @abstractmethod
    def connected(self) -> bool:
        """Whether the way is there now."""

    @abstractmethod
    def send(
        self, action: str, type: str, goal: Values, feedback: Callable[[Values], None]
    ) -> Sent:
        """Send a goal; raises Gone, and Rejected where it does not fit the type."""

    @abstractmethod
    def cancel_all(self, action: str) -> None:
        """Ask for the end of every goal of an action, whoever sent it; raises Gone."""

    @abstractmethod
    def listen(self, topic: str, type: str, heard: Callable[[Values], None]) -> None:
        """Hear a topic from now on; raises Gone."""
