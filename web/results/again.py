"""Measure again: the run's own protocol with only those points, its text otherwise unchanged."""

import re

from ...engine.journal.encode import QUANTITY_KEY
from ...engine.language.source import Source
from ...engine.views.english import bare
from ...schemas import protocol as p
from ..local.refusal import Refusal
from ..models.results import AgainText, MeasureAgain
from ..runs.open_run import OpenRun
from ..runs.runs import Runs

MOST = 5000


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
    items = "".join(f"\n{_indent(checked.source, place)}- {_item(raw, i)}" for i in indexes)
    text = _replaced(checked.source, place, items, raw)
    title = asked.name or f"{checked.protocol.name if checked.protocol else 'run'} again"[:80]
    text = re.sub(r"(?m)^name:.*$", f"name: {title}", text, count=1)
    mark = f"# {len(indexes)} points of {run.id}, to be measured again\n"
    return AgainText(
        name=f"{title}.yaml", text=mark + text, points=len(indexes), params=_params(run)
    )


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


def _indent(source: Source, place: tuple[str | int, ...]) -> str:
    """The items are indented by two more columns than the name of the loop's variable."""
    _, column, _ = source.place(place, key=True)
    return " " * (column + 1)


def _replaced(source: Source, place: tuple[str | int, ...], items: str, raw: object) -> str:
    """The text with other items; a mapping in braces is expanded, since a block list follows."""
    node = source.node(place)
    around = source.node(place[:-1])
    if node is None or around is None:
        raise Refusal(409, "UNREADABLE", "the loop's items cannot be found in the text")
    text = source.text
    if text[around.start] == "{":
        flow = ", ".join(part[2:] for part in (line.strip() for line in items.splitlines()) if part)
        return f"{text[: node.start]}[{flow}]{text[node.end :]}"
    return text[: node.start].rstrip(" ") + items + text[node.end :]


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
