"""The whole page: devices, parameters, procedure, the end, a resumed run, and the outputs."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from ...check import Checked
from ..count import count_runs, number_of
from ..english import joined, upper_first
from ..forecast import Outlook, outlook
from .act import does, subject
from .failing import duration, retry_sentence
from .item import WIDTH, Item, markdown, markdown_lines, text_lines
from .speak import said, spoken
from .steps import sentences

Layout = Callable[[list["Section"]], Iterator[str]]


@dataclass(slots=True)
class Section:
    """A heading with sentences, numbered items, or name and meaning."""

    title: str
    items: list[Item] = field(default_factory=list)
    terms: list[tuple[str, str]] = field(default_factory=list)
    text: str = ""


def page(checked: Checked) -> list[Section]:
    """The sections of a protocol; the first has its name for a title."""
    view = outlook(checked)
    protocol = view.protocol
    found = [Section(protocol.name, text=protocol.summary)]
    found.append(Section("Devices", terms=list(_devices(checked, view))))
    found.append(Section("Parameters", terms=list(_params(view))))
    found.append(Section("Procedure", sentences(view, protocol.steps, ("steps",)), text=_all(view)))
    last = sentences(view, protocol.finally_, ("finally",))
    found.append(Section("At the end, whatever happened", last, text=_safe(view)))
    if protocol.on_resume:
        again = sentences(view, protocol.on_resume, ("on_resume",))
        text = "First these steps, then the procedure continues from the first unfinished step."
        found.append(Section("When a run is resumed after a stop", again, text=text))
    outputs = [(n, spoken(view, raw, ("outputs", n))) for n, raw in protocol.outputs.items()]
    found.append(Section("Outputs", terms=outputs))
    return [section for section in found if section.items or section.terms or section.text]


def _devices(checked: Checked, view: Outlook) -> Iterator[tuple[str, str]]:
    assert checked.lab is not None
    lab = checked.lab.lab
    where = f"the lab {lab.name!r}" + (
        ", which is simulated" if lab.simulated and lab.name != "simulated" else ""
    )
    for role, bound in view.roles.items():
        summary = bound.contract.summary or f"A device that keeps {bound.contract.type}"
        yield role, f"{summary} ({bound.contract.type}; {bound.device} of {where})"


def _params(view: Outlook) -> Iterator[tuple[str, str]]:
    values = view.names["params"]
    for name, param in view.protocol.params.items():
        value = said(values[name]) if name in values else "given for each run"
        edges = (param.minimum, param.maximum)
        low, high = (str(edge) if edge is not None else None for edge in edges)
        within = ""
        if low is not None or high is not None:
            within = (
                f", {low} to {high}"
                if low and high
                else f", {low} or more"
                if low
                else f", {high} or less"
            )
        about = (
            f" ({param.summary}{within})" if param.summary else f" ({within[2:]})" if within else ""
        )
        yield name, f"{value}{about}"


def _all(view: Outlook) -> str:
    """What applies to all steps, and how many actions there are."""
    protocol = view.protocol
    number = number_of(count_runs(view, protocol.steps, ("steps",)))
    parts = [f"{upper_first(number)} action{'' if number == '1' else 's'} if nothing fails."]
    if protocol.defaults.timeout is not None:
        limit = duration(protocol.defaults.timeout)
        parts.append(f"Each action has {limit} unless another time is given.")
    parts.append(
        retry_sentence(protocol.defaults.retry, "an action").replace("If that fails", "If it fails")
    )
    parts.append("A step that fails for good ends the run, unless stated otherwise.")
    return " ".join(part for part in parts if part)


def _safe(view: Outlook) -> str:
    safe = []
    for bound in view.roles.values():
        contract = bound.contract
        done = [does(name, contract.actions[name]) for name in contract.safe_state]
        safe += [f"{subject(bound)} {joined(done)}"] if done else []
    if not safe:
        return ""
    return f"Last, each device that was used is brought to its safe state: {'; '.join(safe)}."


def as_text(sections: Sequence[Section]) -> Iterator[str]:
    """For a terminal."""
    from textwrap import wrap

    for index, section in enumerate(sections):
        if index:
            yield ""
        yield section.title
        yield ("=" if index == 0 else "-") * len(section.title)
        after = section.title.startswith("At the end")
        lines = wrap(section.text, WIDTH)
        yield from () if after else lines
        wide = min(max((len(name) for name, _ in section.terms), default=0), 24)
        for name, meaning in section.terms:
            first = f"  {name:<{wide}}  "
            yield from wrap(
                meaning, WIDTH, initial_indent=first, subsequent_indent=" " * len(first)
            )
        yield from text_lines(section.items)
        yield from lines if after else ()


def as_markdown(sections: Sequence[Section]) -> Iterator[str]:
    """For a page, or an electronic lab book."""
    for index, section in enumerate(sections):
        yield f"{'#' if index == 0 else '##'} {markdown(section.title)}"
        yield ""
        after = section.title.startswith("At the end")
        if section.text and not after:
            yield from (markdown(section.text), "")
        for name, meaning in section.terms:
            yield f"- **{markdown(name)}**: {markdown(meaning)}"
        items = list(markdown_lines(section.items))
        yield from items
        if section.terms or items:
            yield ""
        if section.text and after:
            yield from (markdown(section.text), "")
