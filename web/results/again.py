"""Measure these again: the run's own protocol with just those points, and a text that stays as it was."""

import asyncio
import re

from ...engine.encode import QUANTITY_KEY
from ...engine.language.source import Source
from ...engine.views.english import bare
from ...schemas import protocol as p
from ..guard.refusal import Refusal
from ..live.runs import Runs
from ..live.watched import Watched
from ..models.results import AgainText, MeasureAgain

MOST = 5000


class Again:
    """Makes the text; nothing is saved."""

    def __init__(self, runs: Runs) -> None:
        self._runs = runs

    async def text(self, id: str, asked: MeasureAgain) -> AgainText:
        """The protocol; raises Refusal where the points are of no loop that could be cut down."""
        run = await self._runs.opened(id)
        return await asyncio.to_thread(again_text, run, asked)


def again_text(run: Watched, asked: MeasureAgain) -> AgainText:
    """The run's protocol with another list of items in one place."""
    outline, checked = run.inputs.outline, run.inputs.checked
    if outline is None or checked is None or checked.source is None:
        raise Refusal(409, "UNREADABLE", "the run's own protocol cannot be read any more")
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


def _loop(run: Watched, asked: MeasureAgain) -> str:
    loops = [t for t in run.picture.tables.values() if not t.within and "*" not in t.loop]
    fitting = [t.loop for t in loops if asked.loop in (None, t.loop) and asked.keys[0] in t.slots]
    if len(fitting) != 1:
        known = ", ".join(t.loop for t in loops) or "none"
        raise Refusal(
            422, "NO_LOOP", f"which loop are these points of? Outermost loops: {known}",
            "say `loop`; points of inner loops cannot be chosen one by one",
        )  # fmt: skip
    return fitting[0]


def _indexes(run: Watched, loop: str, keys: list[str]) -> list[int]:
    table = run.picture.tables[loop, ""]
    unknown = [key for key in keys if key not in table.slots]
    if unknown:
        raise Refusal(404, "NOT_FOUND", f"the run has no point {unknown[0]!r}")
    indexes = sorted({table.index[table.slots[key]] for key in keys})
    if len(indexes) > MOST:
        raise Refusal(422, "TOO_MANY", f"{len(indexes):,} points; {MOST:,} are the most")
    return indexes


def _item(raw: object, index: int) -> str:
    """One of the items as an expression: whatever they are, its fields and units stay."""
    if isinstance(raw, list):
        raise Refusal(422, "A_LIST", "the items are a list in the protocol already: edit it there")
    inner = bare(raw)
    inner = inner if re.fullmatch(r"[\w.]+(\(.*\))?", inner, re.DOTALL) else f"({inner})"
    return '"${{ ' + inner.replace("\\", "\\\\").replace('"', "'") + f"[{index}]" + ' }}"'


def _indent(source: Source, place: tuple[str | int, ...]) -> str:
    """The items stand two columns deeper than the name of the loop's variable."""
    _, column, _ = source.place(place, key=True)
    return " " * (column + 1)


def _replaced(source: Source, place: tuple[str | int, ...], items: str, raw: object) -> str:
    """The text with other items; a mapping in braces is opened, since a list of lines follows."""
    node = source.node(place)
    around = source.node(place[:-1])
    if node is None or around is None:
        raise Refusal(409, "UNREADABLE", "the loop's items cannot be found in the text")
    text = source.text
    if text[around.start] == "{":
        flow = ", ".join(part[2:] for part in (line.strip() for line in items.splitlines()) if part)
        return f"{text[: node.start]}[{flow}]{text[node.end :]}"
    return text[: node.start].rstrip(" ") + items + text[node.end :]


def _params(run: Watched) -> dict[str, object]:
    """What the run had set, as the form takes it."""
    told: dict[str, object] = {}
    for name, value in run.picture.params.items():
        if isinstance(value, dict) and QUANTITY_KEY in value:
            magnitude, unit = value[QUANTITY_KEY]
            told[name] = f"{magnitude:.12g} {unit}"
        else:
            told[name] = value
    return told
