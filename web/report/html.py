"""The few HTML elements that the report is built from; all text passed in is escaped."""

import html
from collections.abc import Iterable, Sequence

from .formatting import moment


class Html(str):
    """Text that is HTML already."""

    __slots__ = ()


BREAK = Html("<br>")


def text(value: object) -> Html:
    """A value as HTML: escaped unless it is already markup."""
    if isinstance(value, Html):
        return value
    return Html(html.escape(str(value), quote=True))


def join(parts: Iterable[object], between: str = "") -> Html:
    """Several pieces as one."""
    return Html(between.join(text(part) for part in parts))


def tag(name: str, *inside: object, **attributes: str) -> Html:
    """One element; `class_` and `http_equiv` become `class` and `http-equiv`."""
    told = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{text(given)}"' for key, given in attributes.items()
    )
    return Html(f"<{name}{told}>{join(inside)}</{name}>")


def section(anchor: str, title: str, *inside: object) -> Html:
    """A section of the page with its heading; empty if it has no content."""
    body = join(inside)
    if not body:
        return Html()
    heading = tag("h2", title, id=f"{anchor}-title")
    return tag("section", heading, body, id=anchor, aria_labelledby=f"{anchor}-title")


def table(
    caption: str, header: Sequence[str], rows: Iterable[Sequence[object]], *, numbers: str = ""
) -> Html:
    """A table; `numbers` marks the columns that hold numbers, as in `..nn`.

    Empty if there are no rows. The first cell of each row is its heading.
    """
    kinds = numbers.ljust(len(header), ".")
    body = join(_row(row, kinds) for row in rows)
    if not body:
        return Html()
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


def _row(row: Sequence[object], kinds: str) -> Html:
    first, *rest = row
    cells = [tag("th", first, scope="row")]
    cells += [tag("td", cell, **_kind(kind)) for cell, kind in zip(rest, kinds[1:], strict=True)]
    return tag("tr", *cells)


def _kind(kind: str) -> dict[str, str]:
    return {"class_": "number"} if kind == "n" else {}


def facts(rows: Iterable[tuple[str, object]]) -> Html:
    """Names and values, as a description list."""
    return tag("dl", *(tag("div", tag("dt", name), tag("dd", told)) for name, told in rows))


def folded(summary: str, *inside: object) -> Html:
    """A collapsed section."""
    return tag("details", tag("summary", summary), *inside)


def paragraph(*inside: object) -> Html:
    """A paragraph."""
    return tag("p", *inside)


def code(value: object) -> Html:
    """A name, a path or a hash, verbatim."""
    return tag("code", value)


def label(value: object) -> Html:
    """A short name that stays on one line, such as `gantry.move_to`."""
    return tag("code", value, class_="name")


def at_time(at: str) -> Html:
    """A record's time: shown to the second, exact in its attribute."""
    return tag("time", moment(at), datetime=at, class_="when")


def listed(items: Iterable[object]) -> Html:
    """A list; a single item is shown without one."""
    found = list(items)
    return text(found[0]) if len(found) == 1 else tag("ul", *(tag("li", item) for item in found))
