"""Measure again: the run's own protocol with only those points, its text otherwise unchanged."""

import re
from math import ceil

from ...engine.journal.encode import QUANTITY_KEY
from ...engine.language.shape import Place
from ...engine.language.source import Source
from ...engine.views.english import bare
from ...schemas import protocol as p
from ..local.refusal import Refusal
from ..models.results import AgainText, MeasureAgain
from ..runs.open_run import OpenRun
from ..runs.runs import Runs

MOST = 5000
Edit = tuple[int, int, str]
"""From an offset of the text to another: what stands there instead."""


class Again:
    """Makes the protocol text; saves nothing."""

    def __init__(self, runs: Runs) -> None:
        self._runs = runs

    async def text(self, id: str, asked: MeasureAgain) -> AgainText:
        """The protocol; raises Refusal if the points are not from a loop that can be reduced."""
        return again_text(await self._runs.opened(id), asked)


def again_text(run: OpenRun, asked: MeasureAgain) -> AgainText:
    """The run's protocol with the items of one loop replaced."""
    outline, checked = run.inputs.outline, run.inputs.checked
    if outline is None or checked is None or checked.source is None:
        raise Refusal(409, "UNREADABLE", "the run's own protocol can no longer be read")
    loop = _loop(run, asked)
    step = outline.steps[loop]
    if not isinstance(step.step, p.Foreach) or step.view is None or step.view.within:
        raise Refusal(
            422, "NO_LOOP", "only the points of a `foreach` of the protocol itself can be chosen"
        )
    indexes = _indexes(run, loop, asked.keys)
    ((name, raw),) = step.step.foreach.items()
    place = (*step.place, "foreach", name)
    source, number = checked.source, len(indexes)
    items = "".join(f"\n{_indent(source, place)}- {_item(raw, i)}" for i in indexes)
    title = asked.name or f"{checked.protocol.name if checked.protocol else 'run'} again"[:80]
    words = f"{number} point{'s' if number > 1 else ''} of {run.id}, to be measured again"
    edits = [
        _items_edit(source, place, items), _edit(source, ("name",), title),
        _edit(source, ("summary",), f'"{words}"'), _limit(run, source, loop, number),
    ]  # fmt: skip
    text = source.text
    for start, end, new in sorted((edit for edit in edits if edit is not None), reverse=True):
        text = text[:start] + new + text[end:]
    return AgainText(
        name=f"{title}.yaml", text=f"# {words}\n{text}", points=number, params=_params(run)
    )


def _limit(run: OpenRun, source: Source, loop: str, number: int) -> Edit | None:
    """As many of these points may fail as of all points, in proportion."""
    assert run.inputs.outline is not None
    step, total = run.inputs.outline.steps[loop], run.picture.tables[loop, ""].total
    limits = step.step.keep_going
    if limits is None or not isinstance(limits.max_failed, int) or not total:
        return None
    most = min(limits.max_failed, ceil(limits.max_failed * number / total))
    return _edit(source, (*step.place, "keep_going", "max_failed"), str(most))


def _edit(source: Source, place: Place, new: str) -> Edit | None:
    """Another value at a place; None where there is nothing."""
    node = source.node(place)
    if node is None:
        return None
    line_end = "\n" if source.text[node.start : node.end].endswith("\n") else ""
    return node.start, node.end, new + line_end


def _loop(run: OpenRun, asked: MeasureAgain) -> str:
    loops = [t for t in run.picture.tables.values() if not t.within and "*" not in t.loop]
    fitting = [t.loop for t in loops if asked.loop in (None, t.loop) and asked.keys[0] in t.slots]
    if len(fitting) != 1:
        known = ", ".join(t.loop for t in loops) or "none"
        raise Refusal(
            422, "NO_LOOP", f"which loop do these points belong to? Outermost loops: {known}",
            "give `loop`; points of inner loops cannot be chosen one by one",
        )  # fmt: skip
    return fitting[0]


def _indexes(run: OpenRun, loop: str, keys: list[str]) -> list[int]:
    table = run.picture.tables[loop, ""]
    unknown = [key for key in keys if key not in table.slots]
    if unknown:
        raise Refusal(404, "NOT_FOUND", f"the run has no point {unknown[0]!r}")
    indexes = sorted({table.index[table.slots[key]] for key in keys})
    if len(indexes) > MOST:
        raise Refusal(422, "TOO_MANY", f"{len(indexes):,} points; at most {MOST:,} are allowed")
    return indexes


def _item(raw: object, index: int) -> str:
    """One item as an expression that keeps its fields and units."""
    if isinstance(raw, list):
        raise Refusal(422, "A_LIST", "the items are already a list in the protocol: edit it there")
    inner = bare(raw)
    inner = inner if re.fullmatch(r"[\w.]+(\(.*\))?", inner, re.DOTALL) else f"({inner})"
    return '"${{ ' + inner.replace("\\", "\\\\").replace('"', "'") + f"[{index}]" + ' }}"'


def _indent(source: Source, place: Place) -> str:
    """The items are indented by two more columns than the name of the loop's variable."""
    _, column, _ = source.place(place, key=True)
    return " " * (column + 1)


def _items_edit(source: Source, place: Place, items: str) -> Edit:
    """Other items; in a mapping in braces as a list in brackets."""
    node = source.node(place)
    around = source.node(place[:-1])
    if node is None or around is None:
        raise Refusal(409, "UNREADABLE", "the loop's items cannot be found in the text")
    text = source.text
    if text[around.start] == "{":
        flow = ", ".join(part[2:] for part in (line.strip() for line in items.splitlines()) if part)
        return node.start, node.end, f"[{flow}]"
    return len(text[: node.start].rstrip(" ")), node.end, items


def _params(run: OpenRun) -> dict[str, object]:
    """The run's parameters in the format of the form."""
    values: dict[str, object] = {}
    for name, value in run.picture.params.items():
        if isinstance(value, dict) and QUANTITY_KEY in value:
            magnitude, unit = value[QUANTITY_KEY]
            values[name] = f"{magnitude:.12g} {unit}"
        else:
            values[name] = value
    return values
