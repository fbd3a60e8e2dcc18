"""The few pieces of HTML that the report is built of; whatever comes in as text is escaped."""

import html
from collections.abc import Iterable, Sequence

from .words import moment


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


BREAK = Markup("<br>")


def text(value: object) -> Markup:
    """A value as HTML: escaped, unless it is markup already."""
    if isinstance(value, Markup):
        return value
    return Markup(html.escape(str(value), quote=True))


def join(parts: Iterable[object], between: str = "") -> Markup:
    """Several pieces as one."""
    return Markup(between.join(text(part) for part in parts))


def tag(name: str, *inside: object, **attributes: str) -> Markup:
    """One element; `class_` and `http_equiv` become `class` and `http-equiv`."""
    told = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{text(given)}"' for key, given in attributes.items()
    )
    return Markup(f"<{name}{told}>{join(inside)}</{name}>")


def section(anchor: str, title: str, *inside: object) -> Markup:
    """A part of the page with its heading; empty where it would hold nothing."""
    body = join(inside)
    if not body:
        return Markup()
    heading = tag("h2", title, id=f"{anchor}-title")
    return tag("section", heading, body, id=anchor, aria_labelledby=f"{anchor}-title")


def table(
    caption: str, header: Sequence[str], rows: Iterable[Sequence[object]], *, numbers: str = ""
) -> Markup:
    """A table; `numbers` says of each column whether it holds numbers, as in `..nn`.

    Empty where there are no rows. The first cell of each row is its heading.
    """
    kinds = numbers.ljust(len(header), ".")
    body = join(_row(row, kinds) for row in rows)
    if not body:
        return Markup()
    head = join(
        tag("th", cell, scope="col", **_kind(kind))
        for cell, kind in zip(header, kinds, strict=True)
    )
    inner = join(
        [tag("caption", caption), tag("thead", tag("tr", head)), tag("tbody", body)]
    )  # fmt: skip
    return tag(
        "div", tag("table", inner), class_="scroll", role="region", aria_label=caption, tabindex="0"
    )


def _row(row: Sequence[object], kinds: str) -> Markup:
    first, *rest = row
    cells = [tag("th", first, scope="row")]
    cells += [tag("td", cell, **_kind(kind)) for cell, kind in zip(rest, kinds[1:], strict=True)]
    return tag("tr", *cells)


def _kind(kind: str) -> dict[str, str]:
    return {"class_": "number"} if kind == "n" else {}


def facts(rows: Iterable[tuple[str, object]]) -> Markup:
    """Names and what they are: a description list."""
    return tag("dl", *(tag("div", tag("dt", name), tag("dd", told)) for name, told in rows))


def folded(summary: str, *inside: object) -> Markup:
    """Something that is there for who opens it."""
    return tag("details", tag("summary", summary), *inside)


def paragraph(*inside: object) -> Markup:
    """A paragraph."""
    return tag("p", *inside)


def code(value: object) -> Markup:
    """A name, a path or a hash, as it is written."""
    return tag("code", value)


def label(value: object) -> Markup:
    """A short name that stays on one line, such as `gantry.move_to`."""
    return tag("code", value, class_="name")


def at_time(at: str) -> Markup:
    """A moment of a record: to the second for the eye, exact in its attribute."""
    return tag("time", moment(at), datetime=at, class_="when")


def listed(items: Iterable[object]) -> Markup:
    """A list; a single item is no list."""
    found = list(items)
    return text(found[0]) if len(found) == 1 else tag("ul", *(tag("li", item) for item in found))
