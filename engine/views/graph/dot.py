"""The tree in DOT, for Graphviz: `labrun graph FILE --format dot | dot -Tsvg`."""

from collections.abc import Iterator

from .mermaid import COLOURS
from .node import Node

SHAPES = {
    "sequence": "box", "set": "box3d", "loop": "hexagon", "branch": "diamond", "use": "folder",
    "retry": "box", "fallback": "octagon", "guard": "cds", "action": "box", "person": "note",
    "instant": "box",
}  # fmt: skip
ROUND = ("retry", "instant", "action")


def dot(trees: dict[str, Node]) -> str:
    """The trees of a protocol as one digraph, a box around each phase if there are several."""
    return "\n".join(_lines(trees)) + "\n"


def escaped(text: str) -> str:
    """A text inside the double quotes of a DOT label."""
    plain = "".join(c if c.isprintable() else " " for c in text)
    # In a label an entity such as &lt; would be read as the character.
    return plain.replace("\\", "\\\\").replace('"', '\\"').replace("&", "&amp;")


def _lines(trees: dict[str, Node]) -> Iterator[str]:
    yield "digraph protocol {"
    yield "  graph [ordering=out, nodesep=0.25, ranksep=0.4, fontname=Helvetica, fontsize=12];"
    yield "  node [fontname=Helvetica, fontsize=10, style=filled, margin=0.12];"
    yield '  edge [fontname=Helvetica, fontsize=9, color="#555555", arrowsize=0.7];'
    number = 0
    for index, (title, tree) in enumerate(trees.items()):
        nodes = {id(node): f"n{number + place}" for place, node in enumerate(tree.all())}
        number += len(nodes)
        yield f"  subgraph cluster_{index} {{"
        yield (
            f'    label="{escaped(title)}"; color="#bbbbbb";'
            if len(trees) > 1
            else "    color=none;"
        )
        for node in tree.all():
            yield "    " + _node(nodes[id(node)], node)
        for node in tree.all():
            for below in node.below:
                label = f' [label="{escaped(below.edge)}"]' if below.edge else ""
                yield f"    {nodes[id(node)]} -> {nodes[id(below)]}{label};"
        yield "  }"
    yield "}"


def _node(name: str, node: Node) -> str:
    fill, stroke = COLOURS[node.kind]
    style = 'style="filled,rounded", ' if node.kind in ROUND else ""
    label = "\\n".join(escaped(line) for line in node.lines)
    shape = SHAPES[node.kind]
    return f'{name} [label="{label}", shape={shape}, {style}fillcolor="{fill}", color="{stroke}"];'
