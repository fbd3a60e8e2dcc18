"""The tree as a Mermaid flowchart: GitHub, GitLab and many editors draw it."""

import re
from collections.abc import Iterator

from .node import Node

SHAPES = {
    "sequence": ("[", "]"), "set": ("[[", "]]"), "loop": ("{{", "}}"), "branch": ("{", "}"),
    "use": ("[/", "/]"), "retry": ("([", "])"), "fallback": ("(", ")"), "guard": (">", "]"),
    "action": ("[", "]"), "person": ("[/", "\\]"), "instant": ("(", ")"),
}  # fmt: skip
COLOURS = {
    "sequence": ("#f4f4f4", "#777777"), "set": ("#dcecf9", "#2b6ca3"),
    "loop": ("#e7f3e4", "#3d7d33"), "branch": ("#fdf3d8", "#a97b08"),
    "use": ("#ece5f6", "#6a4a9c"), "retry": ("#fde9dc", "#b85c1c"),
    "fallback": ("#fbe3e3", "#b03a3a"), "guard": ("#fdf3d8", "#a97b08"),
    "action": ("#ffffff", "#2b6ca3"), "person": ("#fff9c9", "#8a7d00"),
    "instant": ("#ffffff", "#777777"),
}  # fmt: skip
SPECIAL = re.compile(r"""["#<>&`*|\\%]|(?<![^\W_])_|_(?![^\W_])|(?<=fa):|//""")
MOST_EDGES = 500
"""Mermaid refuses to draw more, unless configured otherwise."""


def mermaid(trees: dict[str, Node]) -> str:
    """The trees of a protocol as one flowchart, a box around each phase if there are several."""
    return "\n".join(_lines(trees)) + "\n"


def edges(trees: dict[str, Node]) -> int:
    """How many arrows the drawing has."""
    return sum(len(tree.all()) - 1 for tree in trees.values())


def escaped(text: str) -> str:
    """A text inside the quotes of a label: every special character as its number."""
    return SPECIAL.sub(lambda match: "".join(f"#{ord(c)};" for c in match[0]), _printable(text))


def _printable(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text)


def _lines(trees: dict[str, Node]) -> Iterator[str]:
    yield "flowchart TD"
    number = 0
    for index, (title, tree) in enumerate(trees.items()):
        nodes = {id(node): f"n{number + place}" for place, node in enumerate(tree.all())}
        number += len(nodes)
        if len(trees) > 1:
            yield f'  subgraph phase{index}["{escaped(title)}"]'
        for node in tree.all():
            yield "    " + _node(nodes[id(node)], node)
        for node in tree.all():
            for below in node.below:
                label = f'|"{escaped(below.edge)}"|' if below.edge else ""
                yield f"    {nodes[id(node)]} -->{label} {nodes[id(below)]}"
        if len(trees) > 1:
            yield "  end"
    kinds = {node.kind for tree in trees.values() for node in tree.all()}
    for kind, (fill, stroke) in COLOURS.items():
        if kind in kinds:
            yield f"  classDef {kind}Node fill:{fill},stroke:{stroke},color:#1a1a1a"


def _node(name: str, node: Node) -> str:
    before, after = SHAPES[node.kind]
    label = "<br/>".join(escaped(line) for line in node.lines)
    return f'{name}{before}"{label}"{after}:::{node.kind}Node'
