"""What a person watching a run wants to know: points done, rate, time left, what runs now."""

import time
from dataclasses import dataclass, field

from ...schemas.event import Event
from ...schemas.journal import ended_as
from ..journal.encode import QUANTITY_KEY
from ..run.questions import HAPPENED


@dataclass(slots=True)
class LoopProgress:
    """How far one loop is."""

    path: str
    total: int | None
    done: int = 0
    failed: int = 0
    key: str = ""
    began: float = field(default_factory=time.monotonic)
    began_done: int = 0

    @property
    def rate(self) -> float:
        """Iterations per second since this engine started the loop."""
        elapsed = time.monotonic() - self.began
        return (self.done - self.began_done) / elapsed if elapsed > 0 else 0.0

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

    def _iteration(self, event: Event) -> None:
        if event.state == "ended":
            self.loops.pop(event.path, None)
            return
        loop = self.loops.get(event.path)
        if loop is None:
            loop = LoopProgress(event.path, event.data["total"])
            self.loops[event.path] = loop
        if event.state == "running":
            if not loop.key:  # skipping the work of earlier engine sessions is over
                loop.began_done = event.data["done"]
            loop.key = event.data["key"]
        loop.done, loop.failed = event.data["done"], event.data["failed"]

    def now(self) -> str:
        """What runs now, in a few words."""
        if self.paused:
            return "paused"
        told = {
            label + (f" ({self.feedback[path]})" if self.feedback.get(path) else "")
            for path, label in self.actions.items()
        }
        return ", ".join(sorted(told))


def duration_text(seconds: float | None) -> str:
    """`1:02:03`, `4:05`, or a dash."""
    if seconds is None:
        return "-"
    whole = round(seconds)
    hours, minutes, rest = whole // 3600, whole // 60 % 60, whole % 60
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def rate_text(rate: float) -> str:
    """Points per second, or per minute if they are slow."""
    return f"{rate:.1f}/s" if rate >= 0.5 else f"{rate * 60:.1f}/min"


def value_text(value: object) -> str:
    """An output as people write it: `0.2 mm`, `1071`."""
    if isinstance(value, dict) and QUANTITY_KEY in value:
        magnitude, unit = value[QUANTITY_KEY]
        return f"{magnitude:.12g} {unit}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return ", ".join(value_text(item) for item in value) or "none"
    return "-" if value is None else str(value)


def choices_text(event: Event) -> str:
    """The choices of a question, each with the values that it needs."""
    needs = "".join(f" {name}=..." for name in event.data.get("wants", {}).get("required", []))
    return "/".join(f"{c}{needs}" if c == HAPPENED else c for c in event.data["choices"])


def ending_text(event: Event) -> str:
    """The last line of a run, for people."""
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
    if event.state != "succeeded":
        lines.append(f"continue with: labrun resume {event.path.rpartition('_')[2]}")
    return lines
