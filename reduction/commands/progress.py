"""Progress of a batch: a bar in a terminal, a line every few seconds elsewhere."""

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, TextIO

from ..batch.work import Done
from .say import say

if TYPE_CHECKING:
    from rich.progress import Progress

EVERY_S = 5.0


class Shown:
    """Receives every spectrum and shows progress on stderr."""

    def __init__(self, out: TextIO | None = None) -> None:
        self.out = out or sys.stderr
        self.total = self.done = self.failed = 0
        self.began = self.said_at = time.monotonic()
        self.waited_s = 0.0
        self.bar: Progress | None = None

    def __enter__(self) -> "Shown":
        if self.out.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
            from rich.progress import TimeRemainingColumn as Left

            self.bar = Progress(
                TextColumn("reducing"), BarColumn(), MofNCompleteColumn(),
                TextColumn("{task.fields[rate]:.0f}/s"), Left(), TextColumn("{task.fields[bad]}"),
                console=Console(file=self.out), transient=True,
            )  # fmt: skip
            self.task = self.bar.add_task("", total=None, rate=0.0, bad="")
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
        self._show()

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

    def rate(self, now: float) -> float:
        """Spectra per second since the first was done: starting and compiling do not count."""
        return max(self.done - 1, 0) / max(now - self.began - self.waited_s, 1e-3)

    def _show(self) -> None:
        now = time.monotonic()
        rate = self.rate(now)
        bad = f"{self.failed} failed" if self.failed else ""
        if self.bar is not None:
            self.bar.update(
                self.task, total=self.total, completed=self.done, rate=rate, bad=bad
            )  # fmt: skip
        elif now - self.said_at >= EVERY_S and self.done:
            self.said_at = now
            said = f"{self.done}/{self.total} spectra"
            if self.done > 1:
                left = (self.total - self.done) / rate
                said += f", {rate:.0f}/s, {left:.0f} s left"
            say(f"{said} {bad}".rstrip())
