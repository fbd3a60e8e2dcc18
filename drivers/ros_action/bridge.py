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
    def send(
        self, action: str, type: str, goal: Values, feedback: Callable[[Values], None]
    ) -> Sent:
        """Send a goal; raises Gone, and Rejected if it does not fit the type."""

    @abstractmethod
    def cancel_all(self, action: str) -> None:
        """Cancel every goal of an action, whoever sent it; raises Gone."""

    @abstractmethod
    def listen(self, topic: str, type: str, heard: Callable[[Values], None]) -> None:
        """Subscribe to a topic; raises Gone."""
