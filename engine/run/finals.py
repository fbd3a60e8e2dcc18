"""The `finally` of used protocols that are due: their `use` was entered, and they are not over yet.

A `use` enters its own and ends it. What an abort, or a step above that was stopped, has left is begun by
that step or, at the latest, by the end of the run.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from py_trees.behaviour import Behaviour

from ...schemas.protocol import Step
from .frame import Frame, Scope


@dataclass(slots=True)
class Final:
    """The `finally` of one `use`, by its steps, names and frame.

    `begun`: how often it was begun; each time has its own path, and so its own ids.
    """

    build: Callable[[Scope], Behaviour]
    steps: Sequence[Step]
    names: dict[str, Any]
    frame: Frame
    begun: int = 0


class DueFinals:
    """Path of a `use` -> its `finally`, in the order in which they were entered."""

    def __init__(self) -> None:
        self._due: dict[str, Final] = {}

    def __bool__(self) -> bool:
        return bool(self._due)

    def enter(self, path: str, final: Final) -> None:
        """Its `use` begins: from now on it is due."""
        self._due[path] = final

    def of(self, path: str) -> Final:
        """That of one `use`, which must be due."""
        return self._due[path]

    def begin(self, path: str, over: int = 0) -> Final:
        """It begins once more, after `over` times that have ended."""
        final = self._due[path]
        final.begun = max(final.begun, over) + 1
        return final

    def end(self, path: str, *, unfinished: bool = False) -> None:
        """It is over, unless an earlier engine session has left this time unfinished."""
        if unfinished:
            self._due[path].begun -= 1
        else:
            self._due.pop(path, None)

    def under(self, paths: Iterable[str]) -> Iterator[str]:
        """Those due under some paths, the innermost first."""
        above = tuple(f"{path}/" for path in paths)
        return (path for path in reversed(list(self._due)) if f"{path}/".startswith(above))

    def take(self) -> list[tuple[str, Final]]:
        """All that are due, the innermost first; none is from now on."""
        due, self._due = self._due, {}
        return list(reversed(due.items()))
