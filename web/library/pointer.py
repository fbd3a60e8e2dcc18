"""From a position in a text to the value or key there, as a JSON Pointer."""

from ...engine.language.source import Source
from ...engine.language.yaml_node import Node
from ...schemas.problem import Problem


def pointer_of(source: Source, problem: Problem) -> str | None:
    """The pointer of the value that a problem is about; None if in another file or in no value.

    A mapping begins where its first key does: the length shows which of the two is meant.
    """
    if source.root is None or problem.file != source.name:
        return None
    starts = source.lines.starts
    if problem.line > len(starts):
        return None
    offset = starts[problem.line - 1] + problem.column - 1
    return pointer_text(_path(source, source.root, offset, problem.length))


def _path(source: Source, node: Node, offset: int, length: int) -> list[str | int]:
    path: list[str | int] = []
    while True:
        if node.start == offset and source.lines.span(node.start, node.end)[2] == length:
            return path
        part, inner, at_key = _inside(node, offset)
        if part is None or inner is None:
            return path
        path.append(part)
        if at_key:
            return path
        node = inner


def _inside(node: Node, offset: int) -> tuple[str | int | None, Node | None, bool]:
    """The member or item at an offset, and whether the offset is at its key."""
    for index, item in enumerate(node.items or []):
        if item.start <= offset < max(item.end, item.start + 1):
            return index, item, False
    for name, member in (node.members or {}).items():
        start, end = (node.keys or {}).get(name, (0, 0))
        if start <= offset < end:
            return name, member, True
        if member.start <= offset < max(member.end, member.start + 1):
            return name, member, False
    return None, None, False


def pointer_text(path: list[str | int]) -> str:
    """`/steps/0/with/x` (RFC 6901)."""
    return "".join(f"/{str(part).replace('~', '~0').replace('/', '~1')}" for part in path)
