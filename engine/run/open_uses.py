"""Used protocols with an `on_resume` that are under way: entered, and not over."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from py_trees.behaviour import Behaviour

from .frame import Scope


@dataclass(frozen=True, slots=True)
class OpenUse:
    """One of them, by its path in the run and the names it has there: its parameters.

    `build` makes the tree of its `on_resume` with the compiler of the protocol that is run.
    """

    path: str
    names: dict[str, Any]
    build: Callable[[Any, Scope], Behaviour]
