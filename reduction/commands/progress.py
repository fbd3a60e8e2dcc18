"""Progress of a batch: a bar in a terminal, a line every few seconds elsewhere."""

import sys
import time
from collections import deque
from types import TracebackType
from typing import TYPE_CHECKING, TextIO

from ...system.pace import duration_text, rate_text
from ..batch.work import Done
from .say import say

if TYPE_CHECKING:
    from rich.progress import Progress

EVERY_S = 5.0
WINDOW_S = 60.0
"""The rate is that of the last minute."""
APART_S = 0.2
"""What comes within this time of a sample counts as one with it: a chunk arrives at once."""


class Shown:
    """Receives every spectrum and shows progress on stderr."""

    def __init__(self, out: TextIO | None = None) -> None:
        self.out = out or sys.stderr
        self.total = self.done = self.failed = 0
        self.began = self.said_at = time.monotonic()
        self.waited_s = 0.0
        self.recent: deque[tuple[float, int]] = deque()
        """When spectra of the last minute came, and how many were done then."""
        self.bar: Progress | None = None

    def __enter__(self) -> "Shown":
        if self.out.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

            self.bar = Progress(
                TextColumn("reducing"), BarColumn(), MofNCompleteColumn(),
                TextColumn("{task.fields[pace]}"), TextColumn("{task.fields[bad]}"),
                console=Console(file=self.out), transient=True,
            )  # fmt: skip
            self.task = self.bar.add_task("", total=None, pace="", bad="")
            self.bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.bar is not None:
            self.bar.stop()
        self.bar = None

    def expect(self, more: int) -> None:
        """Add `more` spectra to the total."""
        self.total += more
        self._show()

    def take(self, done: Done) -> None:
        """Count one spectrum, reduced or failed."""
        self.done += 1
        if self.done == 1:
            self.waited_s = time.monotonic() - self.began
        self.failed += bool(done.reason)
        self._sample(time.monotonic())
        self._show()

    def _sample(self, now: float) -> None:
        recent = self.recent
        if recent and now - recent[-1][0] < APART_S:
            now = recent.pop()[0]
        recent.append((now, self.done))
        while len(recent) > 2 and recent[1][0] <= now - WINDOW_S:
            recent.popleft()

    def compiling(self) -> None:
        """Explain why the very first reduction is slow."""
        self.say(
            "compiling the loops of the fits, on first use of this version only "
            "(half a minute to two; not counted in the rate)"
        )

    def say(self, text: str) -> None:
        """Print a separate line, above the bar if there is one."""
        if self.bar is not None:
            self.bar.console.print(f"labrun: {text}", highlight=False, markup=False)
        else:
            say(text)

    def pace(self) -> str:
        """`2.1/s, 0:40 left` of the last minute: starting and compiling do not count; empty at first."""
        (first, before), (last, done) = self.recent[0], self.recent[-1]
        if done == before:
            return ""
        rate = (done - before) / (last - first)
        return f"{rate_text(rate)}, {duration_text((self.total - self.done) / rate)} left"

    def _show(self) -> None:
        now = time.monotonic()
        pace = self.pace() if self.recent else ""
        bad = f"{self.failed} failed" if self.failed else ""
        if self.bar is not None:
            self.bar.update(self.task, total=self.total, completed=self.done, pace=pace, bad=bad)
        elif now - self.said_at >= EVERY_S and self.done:
            self.said_at = now
            told = [f"{self.done}/{self.total} spectra", *filter(None, (pace, bad))]
            say(", ".join(told))
