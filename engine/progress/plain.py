"""Progress as plain lines: for logs, pipes and simple terminals."""

import sys
import time
from typing import TextIO

from ...schemas.event import KINDS, Event
from ...system.pace import duration_text, rate_text
from .progress import Progress, choices_text, ending_lines, ending_text, harmless, line_of

EVERY_S = 5.0


class PlainWatch:
    """A line for each thing a person must know, and one every few seconds for the rest."""

    kinds = KINDS - {"step", "safe"}

    def __init__(self, out: TextIO | None = None) -> None:
        self.out = out or sys.stdout
        self.progress = Progress()
        self.name = ""
        self.said_at = time.monotonic()

    def __call__(self, event: Event) -> None:
        self.progress.take(event)
        line = self._line(event)
        if line:
            print(harmless(line), file=self.out, flush=True)

    def _line(self, event: Event) -> str:
        match event.event:
            case "run":
                self.name = event.path.rpartition("_")[2]
                return f"run {event.path}"
            case "question" if event.state == "open":
                choices = choices_text(event)
                values = " [-r NAME=VALUE]" if event.data.get("wants") else ""
                answer = f"labrun answer {self.name} {event.data['id']} CHOICE{values}"
                return f"? {event.text} [{choices}]  ({answer})"
            case "answer":
                return f"  {event.path}: {event.state} ({event.data.get('by', '')})"
            case "finished":
                return "\n".join([ending_text(event), *ending_lines(event)])
            case "iteration" | "goal":
                return self._now_and_then()
            case _:
                return line_of(event)

    def _now_and_then(self) -> str:
        if time.monotonic() - self.said_at < EVERY_S or not self.progress.loops:
            return ""
        now = self.progress.now()
        if not now:
            return ""  # between two actions: the next event says more
        self.said_at = time.monotonic()
        loop = next(iter(self.progress.loops.values()))
        share = f" ({100 * loop.done / loop.total:.0f} %)" if loop.total else ""
        rate = f"{rate_text(loop.rate)}, {duration_text(loop.left_s)} left, " if loop.rate else ""
        return f"{loop.done_text} points{share}, {rate}{loop.failed} failed; now {now}"
