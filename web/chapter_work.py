"""Chapters of the report on the work itself: what was asked, when it was done, by which actions."""

from .inputs import contract_file
from .markup import (
    BREAK,
    Markup,
    at_time,
    code,
    folded,
    join,
    label,
    paragraph,
    section,
    table,
    tag,
)
from .material import Material
from .spans import Life
from .story import interruptions
from .tally import KEPT
from .words import count, duration, seconds_between, value

PROTOCOL_SHOWN = 200_000


def done(title: str, material: Material) -> Markup:
    """The protocol, its parameters, the devices in their roles, and what came out."""
    inputs = material.inputs
    text = inputs.protocol_text[:PROTOCOL_SHOWN]
    return section(
        "what-was-done", title,
        _params(material), _devices(material), _loops(material), _outputs(material),
        folded(f"The protocol as it was run ({inputs.protocol_name})", tag("pre", tag("code", text)))
        if text else "",
    )  # fmt: skip


def _params(material: Material) -> Markup:
    started, inputs = material.story.started, material.inputs
    if started is None:
        return Markup()
    rows = (
        (
            code(name), value(told), "set for this run" if inputs.given(name) else "default",
            inputs.param(name).get("summary", ""),
        )
        for name, told in started.params.items()
    )  # fmt: skip
    return table("Parameters", ["name", "value", "whence", "meaning"], rows)


def _devices(material: Material) -> Markup:
    inputs = material.inputs
    rows = []
    for role, device in material.roles.items():
        boots = material.story.boots.get(device, [])
        again = f", started {len(boots)} times" if len(boots) > 1 else ""
        server = (
            join([code(boots[-1].boot), again, BREAK, "ledger ", code(boots[-1].ledger)])
            if boots
            else tag("span", "no goal was sent to it", class_="soft")
        )
        contract = inputs.contract_of(device)
        rows.append((
            code(role), device, join([contract, BREAK, code(contract_file(contract))]),
            inputs.reached_by(device), server,
        ))  # fmt: skip
    header = ["role", "device", "contract", "driver or address", "server (boot)"]
    return table("Devices", header, rows)


def _loops(material: Material) -> Markup:
    rows = (
        (code(name), f"{n.total:,}", f"{n.succeeded:,}", f"{n.failed:,}", f"{n.skipped:,}")
        for name, n in material.story.loops.items()
    )
    header = ["loop", "iterations", "succeeded", "left out (holes)", "skipped"]
    return table("Loops", header, rows, numbers=".nnnn")


def _outputs(material: Material) -> Markup:
    finished = material.story.finished
    outputs = finished.outputs if finished is not None else {}
    return table("Outputs", ["name", "value"], ((code(n), value(v)) for n, v in outputs.items()))


def when(title: str, material: Material) -> Markup:
    """The lives of the engine, with what lay between them, and the pauses."""
    story = material.story
    if not story.spans.lives:
        return section("when", title, paragraph("The journal holds no record that can be read."))
    rows = [_life_row(life, material) for life in story.spans.lives]
    header = ["engine", "began (UTC)", "last record (UTC)", "lived", "goals sent", "how it ended"]
    holds = (
        (
            at_time(hold.began), hold.by, at_time(hold.ended) if hold.ended else "", hold.ended_by,
            duration(seconds_between(hold.began, hold.ended)) if hold.ended else "not over",
        )
        for hold in story.spans.holds
    )  # fmt: skip
    return section(
        "when", title, _bar(material),
        table("Engines that lived this run, in turn", header, rows, numbers="...nn."),
        table(
            "Interruptions: no engine ran the run",
            ["after", "from (UTC)", "until (UTC)", "length", "under way when it began"],
            (
                (
                    f"engine {last.number}", at_time(last.ended), at_time(following.began),
                    duration(seconds_between(last.ended, following.began)),
                    count(last.under_way, "action"),
                )
                for last, following in interruptions(story)
            ),
            numbers="...n.",
        ),
        _changes(material),
        table("Pauses", ["from (UTC)", "by", "until (UTC)", "ended by", "length"], holds, numbers="....n"),
    )  # fmt: skip


def _changes(material: Material) -> Markup:
    rows = (
        (
            at_time(change.at), code(change.folder),
            ", ".join(f"{name} = {value(told)}" for name, told in change.params.items()),
            f"{len(change.reopened):,}",
        )
        for change in material.story.changes
    )  # fmt: skip
    header = ["when (UTC)", "protocol and lab from then on", "parameters", "iterations done again"]
    return table("Changed on the way", header, rows, numbers="...n")


def _life_row(life: Life, material: Material) -> tuple[object, ...]:
    last = life is material.story.spans.lives[-1]
    ended = f"{life.fate}{f': {life.reason}' if life.reason else ''}" if life.fate else ""
    if not ended and last and material.fate == "running":
        ended = "still running"
    if not ended:
        left = f", {count(life.under_way, 'action')} under way" if life.under_way else ""
        ended = f"gone without a last record (killed, or power lost){left}"
    if life.torn:
        ended += f"; it found the journal's last record torn and cut off {life.torn} bytes"
    return (
        f"{life.number} (labrun {life.labrun})", at_time(life.began), at_time(life.ended),
        duration(life.seconds), f"{life.goals:,}", ended,
    )  # fmt: skip


def _bar(material: Material) -> Markup:
    """The run as a line: green while an engine lived, red in between; nothing for a single life."""
    story = material.story
    lives = story.spans.lives
    if len(lives) < 2:
        return Markup()
    parts: list[tuple[str, float]] = [("ran", lives[0].seconds)]
    for last, following in interruptions(story):
        parts.append(("away", seconds_between(last.ended, following.began)))
        parts.append(("ran", following.seconds))
    whole = sum(length for _, length in parts) or 1.0
    pieces = (tag("span", class_=k, style=f"width:{100 * s / whole:.3f}%") for k, s in parts)
    words = f"{len(lives)} engines in turn, {len(lives) - 1} interruptions"
    legend = paragraph(tag("span", "Green: an engine ran the run; red: none did.", class_="soft"))
    return join([tag("div", *pieces, class_="bar", role="img", aria_label=words), legend])


def actions(title: str, material: Material) -> Markup:
    """How many actions of each kind were sent, and how they went."""
    rows = []
    for told, deed in sorted(material.story.deeds.items()):
        rows.append((
            label(told), f"{deed.sent:,}", f"{deed.succeeded:,}", _marked(deed.failed),
            f"{deed.cancelled:,}", f"{deed.again:,}", _marked(deed.sent - deed.ended),
            duration(deed.mean_s) if deed.timed else "",
            duration(deed.longest_s) if deed.timed else "",
        ))  # fmt: skip
    header = [
        "action", "sent", "succeeded", "failed", "cancelled", "repetitions", "no end known",
        "mean", "longest",
    ]  # fmt: skip
    return section(
        "actions", title,
        table("Goals by device and action", header, rows, numbers=".nnnnnnnn"),
    )  # fmt: skip


def _marked(number: int) -> Markup:
    return tag("span", f"{number:,}", class_="bad") if number else Markup("0")


def logged(title: str, material: Material) -> Markup:
    """Lines that the protocol's `log` steps wrote."""
    story = material.story
    rows = ((at_time(line.at), line.message, code(line.path)) for line in story.logged)
    first = f", the first {KEPT} of {story.log_lines:,}" if story.log_lines > KEPT else ""
    return section(
        "what-the-protocol-said", title,
        table(f"Log{first}", ["when (UTC)", "line", "step"], rows),
    )  # fmt: skip
