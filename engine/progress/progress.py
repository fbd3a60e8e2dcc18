"""What a person watching a run wants to know: points done, rate, time left, what runs now."""

import re
import time
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path

from ...schemas.event import Event
from ...schemas.journal import ended_as
from ..journal.encode import MOMENT_KEY, QUANTITY_KEY
from ..run.questions import HAPPENED

WINDOW = 30
"""The rate is that of the last so many points: what was slow at first says nothing of the rest."""

OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""What moves the cursor, changes colours, rings, or turns the direction of writing."""


@dataclass(slots=True)
class LoopProgress:
    """How far one loop is."""

    path: str
    total: int | None
    done: int = 0
    failed: int = 0
    key: str = ""
    recent: deque[tuple[float, int]] = field(default_factory=lambda: deque(maxlen=WINDOW + 1))
    """When the last points ended, and how many were done then."""

    @property
    def rate(self) -> float:
        """Iterations per second, of the last ones; less while one takes longer than they did."""
        if not self.recent:
            return 0.0
        (first, before), (last, done) = self.recent[0], self.recent[-1]
        if done == before:
            return 0.0
        usual = (last - first) / (done - before)
        elapsed = last - first + max(0.0, time.monotonic() - last - usual)
        return (done - before) / elapsed if elapsed > 0 else 0.0

    def count(self, done: int, failed: int) -> None:
        """Take in how many are done now."""
        if not self.recent or done != self.done:
            self.recent.append((time.monotonic(), done))
        self.done, self.failed = done, failed

    def measure_anew(self) -> None:
        """From now on: the time before says nothing about the rate."""
        self.recent.clear()
        self.recent.append((time.monotonic(), self.done))

    @property
    def left_s(self) -> float | None:
        """Seconds to the end at this rate; None while unknown."""
        if self.total is None or self.rate <= 0:
            return None
        return (self.total - self.done) / self.rate

    @property
    def done_text(self) -> str:
        """`12/1071`, or `12` if the total is not known in advance."""
        return f"{self.done}" if self.total is None else f"{self.done}/{self.total}"


@dataclass(slots=True)
class Progress:
    """The state of a run, built from its events."""

    phase: str = ""
    loops: dict[str, LoopProgress] = field(default_factory=dict)
    actions: dict[str, str] = field(default_factory=dict)
    feedback: dict[str, str] = field(default_factory=dict)
    paused: bool = False

    def take(self, event: Event) -> None:
        """Learn from one event."""
        if event.event == "iteration":
            self._iteration(event)
        elif event.event == "goal":
            if event.state == "sent":
                self.actions[event.path] = event.text
            else:
                self.actions.pop(event.path, None)
                self.feedback.pop(event.path, None)
        elif event.event == "feedback":
            self.feedback[event.path] = event.text
        elif event.event == "phase":
            self.phase = event.path
        elif event.event == "control":
            self.paused = event.state == "pause"
            for loop in self.loops.values():
                loop.measure_anew()

    def _iteration(self, event: Event) -> None:
        if event.state == "ended":
            self.loops.pop(event.path, None)
            return
        loop = self.loops.get(event.path)
        if loop is None:
            loop = LoopProgress(event.path, event.data["total"])
            self.loops[event.path] = loop
        loop.count(event.data["done"], event.data["failed"])
        if event.state == "running":
            if not loop.key:  # skipping the work of earlier engine sessions is over
                loop.measure_anew()
            loop.key = event.data["key"]

    def now(self) -> str:
        """What runs now, in a few words."""
        if self.paused:
            return "paused"
        told = {
            label + (f" ({self.feedback[path]})" if self.feedback.get(path) else "")
            for path, label in self.actions.items()
        }
        return ", ".join(sorted(told))


def value_text(value: object) -> str:
    """An output as people write it: `0.2 mm`, `1071`."""
    if isinstance(value, dict) and QUANTITY_KEY in value:
        magnitude, unit = value[QUANTITY_KEY]
        return f"{magnitude:.12g} {unit.replace(' / ', '/')}"
    if isinstance(value, dict) and MOMENT_KEY in value:
        return str(value[MOMENT_KEY])
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return ", ".join(value_text(item) for item in value) or "none"
    return "-" if value is None else str(value)


def harmless(text: str) -> str:
    """A text without what a terminal obeys: an instrument's answer may hold anything."""
    return OBEYED.sub(lambda found: ascii(found[0])[1:-1], text)


def line_of(event: Event) -> str:
    """What a person must know of this event, on a line of its own; empty for most."""
    match event.event:
        case "log":
            return event.text
        case "control":
            return f"{event.state} ({event.text})"
        case "phase" if event.path != "main":
            return f"{event.path.partition(':')[0]} ..."
        case "report":
            return f"made {event.text}"
        case _:
            return ""


def choices_text(event: Event) -> str:
    """The choices of a question, each with the values that it needs."""
    needs = "".join(f" {name}=..." for name in event.data.get("wants", {}).get("required", []))
    return "/".join(f"{c}{needs}" if c == HAPPENED else c for c in event.data["choices"])


def ending_text(event: Event) -> str:
    """The last line of a run, for people."""
    if event.text.startswith(f"{event.state} "):  # `aborted by Ctrl-C`
        return f"run {event.text}"
    words = f"run {ended_as(event.state, event.data.get('holes', 0))}"
    if event.text and event.state == "succeeded":
        return f"{words}, but {event.text}"
    return f"{words}: {event.text}" if event.text else words


def ending_lines(event: Event) -> list[str]:
    """What follows the last line: outputs, the folder, and how to resume if possible."""
    lines = [f"  {name}: {value_text(value)}" for name, value in event.data["outputs"].items()]
    if event.data.get("points") and (event.state != "succeeded" or event.data["holes"]):
        lines.append(f"  points: {event.data['points']}")
    lines.append(f"everything is in {event.data['folder']}")
    place = Path(event.data["folder"])
    run = event.path.rpartition("_")[2] if place.parent == Path("runs") else str(place)
    resume = f'labrun resume "{run}"' if " " in run else f"labrun resume {run}"
    if event.data.get("stands"):
        lines.append("what failed has happened, so it is done again only if you ask for it")
        lines.append(f"do it again, and continue, with: {resume} --holes")
    elif event.data.get("resumable", event.state != "succeeded"):
        lines.append(f"continue with: {resume}")
    if (holes := event.data["holes"]) and not event.data.get("stands"):
        what = f"its {holes:,} holes" if holes > 1 else "its hole"
        lines.append(f"measure {what} again with: {resume} --holes")
    return lines
