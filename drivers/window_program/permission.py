"""Who may click: a goal, until it is cancelled or everything is halted; never one that ended before."""

from collections.abc import Callable
from contextvars import ContextVar


class Permission:
    """What a goal was allowed belongs to it and to the threads that it began, which may outlive it."""

    def __init__(self) -> None:
        self._halts = 0
        self._held: ContextVar[tuple[int, Callable[[], bool]]] = ContextVar("permission")

    def allow(self, cancelled: Callable[[], bool] = lambda: False) -> None:
        """From here on this goal may click, until it is cancelled or halted."""
        self._held.set((self._halts, cancelled))

    def halt(self) -> None:
        """Nobody who was allowed to click so far may any more."""
        self._halts += 1

    @property
    def halted(self) -> bool:
        """Whether the goal that asks, in its own task or in a thread of it, may not click."""
        halts, cancelled = self._held.get((0, lambda: False))
        return halts != self._halts or cancelled()
