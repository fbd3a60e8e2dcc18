"""A numbered sentence with those below it, and how they are laid out as text or Markdown."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from textwrap import wrap

WIDTH = 88


@dataclass(slots=True)
class Item:
    """A sentence, the steps inside it, and the text after them; a heading has no number."""

    text: str
    below: "list[Item]" = field(default_factory=list)
    after: str = ""
    numbered: bool = True


def text_lines(items: Sequence[Item], number: str = "", indent: str = "  ") -> Iterator[str]:
    """`1`, `1.1`, `1.2`, ... with hanging indents, wrapped."""
    for item, index in _numbered(items):
        if index is None:
            yield from _wrapped(item.text, indent, indent)
            continue
        label = f"{number}{index}"
        first = f"{indent}{label}{'' if number else '.'} "
        hang = " " * len(first)
        yield from _wrapped(item.text, first, hang)
        yield from text_lines(item.below, f"{label}.", hang)
        yield from _wrapped(item.after, hang, hang)


def markdown_lines(items: Sequence[Item], depth: int = 0) -> Iterator[str]:
    """Nested ordered lists; an item without a number is a paragraph between two of them."""
    space, inner = "   " * depth, "   " * (depth + 1)
    for item, index in _numbered(items):
        if index is None:
            yield from ("", f"{space}{markdown(item.text)}", "")
            continue
        yield f"{space}{index}. {markdown(item.text)}"
        yield from markdown_lines(item.below, depth + 1)
        if item.after:
            yield from ("", f"{inner}{markdown(item.after)}", "")


def _numbered(items: Sequence[Item]) -> Iterator[tuple[Item, int | None]]:
    """Each with its number; a heading has none, and the numbers continue below it."""
    index = 0
    for item in items:
        if item.numbered:
            index += 1
            yield item, index
        else:
            yield item, None
            for inner in item.below:
                index += 1
                yield inner, index


def _wrapped(text: str, first: str, hang: str) -> list[str]:
    return wrap(text, WIDTH, initial_indent=first, subsequent_indent=hang)


def markdown(text: str) -> str:
    """A text in which no character formats anything."""
    return "".join(f"\\{c}" if c in "\\`*_<>[]#|" else c for c in text)
