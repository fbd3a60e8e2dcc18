"""A node of the drawn tree, in py_trees' terms, whatever it is drawn with."""

from dataclasses import dataclass, field
from typing import Literal

Kind = Literal[
    "sequence", "set", "loop", "branch", "use", "retry", "fallback", "guard", "action", "person",
    "instant",
]  # fmt: skip


@dataclass(slots=True)
class Node:
    """One node: its kind, the lines of its label, what is below it.

    `step` is the path that the compiled tree gives the step that this node stands for; None for
    what a step only says around itself, such as a retry. `edge` is written on the way to it.
    """

    kind: Kind
    lines: tuple[str, ...]
    below: "list[Node]" = field(default_factory=list)
    step: str | None = None
    edge: str = ""

    def all(self) -> "list[Node]":
        """This node and every one below it, from the top, left to right."""
        found: list[Node] = []
        left: list[Node] = [self]
        while left:
            node = left.pop()
            found.append(node)
            left += reversed(node.below)
        return found
