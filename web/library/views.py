"""The engine's views for the page: sentences, tree, and the path over the bench."""

from math import isinf

from ...engine.check import Checked
from ...engine.lab.lab import LoadedLab
from ...engine.language.shape import Place
from ...engine.views.count import RunCounts, count_runs, number_of
from ...engine.views.forecast import Outlook, outlook
from ...engine.views.preview.plane import Area as PlaneArea
from ...engine.views.preview.walk import Path, Walk
from ...engine.views.words.item import Item
from ...engine.views.words.page import as_markdown, page
from ..local.kept_out import kept_out
from ..models.protocols import (
    Area,
    Preview,
    Track,
    WordItem,
    Words,
    WordSection,
    WordTerm,
)
from .duration import actions_of, time_of
from .form import questions_of
from .timings import Timings


def words_of(checked: Checked) -> Words:
    """Sections, sentences and terms; and the same as Markdown."""
    sections = page(checked)
    told = [
        WordSection(
            title=one.title, text=one.text, items=[_item(item) for item in one.items],
            terms=[WordTerm(name=name, meaning=meaning) for name, meaning in one.terms],
        )
        for one in sections
    ]  # fmt: skip
    return Words(sections=told, markdown="\n".join(as_markdown(sections)))


def _item(item: Item) -> WordItem:
    below = [_item(inner) for inner in item.below]
    return WordItem(text=item.text, below=below, after=item.after, numbered=item.numbered)


def preview_of(checked: Checked, timings: Timings) -> Preview:
    """The path of each device, how often it acts, and how long that takes."""
    view = outlook(checked)
    walk = Walk().follow(view)
    found = _tally(view)
    actions = actions_of(view, found)
    lasers = [actions[label] for label, danger in _dangers(checked).items() if danger == "laser"]
    known = [times for times in lasers if times is not None]
    lab = checked.lab.lab if checked.lab is not None else None
    return Preview(
        tracks=[_track(path, checked.lab) for path in walk.paths.values() if path.points or path.unknown],
        notes=walk.notes, full=walk.full, actions=actions, actions_text=number_of(found),
        shots=sum(known) if len(known) == len(lasers) else None,
        needs_you=questions_of(checked), time_s=time_of(view, found, timings, lab),
    )  # fmt: skip


def _tally(view: Outlook) -> RunCounts:
    place: Place = ("steps",)
    return count_runs(view, view.protocol.steps, place)


def _dangers(checked: Checked) -> dict[str, str | None]:
    """`device.action` -> its danger, for the actions in the protocol's steps."""
    found = {}
    for at in checked.survey.steps if checked.survey is not None else ():
        role, _, name = getattr(at.step, "do", "").partition(".")
        bound = checked.roles.get(role)
        if bound is not None and name in bound.contract.actions and at.place[0] == "steps":
            found[f"{bound.device}.{name}"] = bound.contract.actions[name].danger
    return found


def _track(path: Path, lab: LoadedLab | None) -> Track:
    return Track.of(
        path, device=path.plane.device, contract=path.plane.contract, area=_area(path.plane.area),
        allowed=_area(path.plane.allowed), x_mm=[one.x_mm for one in path.points],
        y_mm=[one.y_mm for one in path.points], track=[one.track for one in path.points],
        joined=[one.joined for one in path.points], keep_out=kept_out(lab, path.plane.device),
    )  # fmt: skip


def _area(area: PlaneArea) -> Area:
    x0, x1, y0, y1 = (None if isinf(edge) else edge for edge in (*area.x, *area.y))
    return Area(x0=x0, x1=x1, y0=y0, y1=y1)
