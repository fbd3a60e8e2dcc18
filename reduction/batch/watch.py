"""Watch folders: new spectra are reduced, and the tables are extended."""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from .batch import Batch
from .gather import Found, gather
from .job import Job
from .source import Source

LOOK_S = 1.0
WRITE_S = 3.0  # between two writes of the tables, while spectra keep coming
WRITE_SHARE = 5.0  # and at least this many times as long as a write took


class Watch:
    """What was seen in the folders, and when. arrived: called with what each scan found."""

    def __init__(
        self,
        given: Sequence[Path],
        job: Job,
        batch: Batch,
        arrived: Callable[[list[Source], Found], None],
        look_s: float = LOOK_S,
    ) -> None:
        self.given, self.job, self.batch, self.arrived = given, job, batch, arrived
        self.look_s = look_s
        self.seen: dict[Path, tuple[int, int]] = {}
        self.taken: dict[Path, tuple[int, int]] = {}
        self.growing = False
        self.written = 0
        self.wrote_at, self.write_took = -1e9, 0.0

    def run(self, until_idle_s: float | None = None) -> None:
        """Run until nothing has arrived for that long, or for ever. Raises what a batch raises."""
        came, looked = time.monotonic(), -1e9
        while True:
            if time.monotonic() - looked >= self.look_s:
                looked = time.monotonic()
                self.look()
            self.batch.step(0.2) if self.batch.busy else time.sleep(0.05)
            self.write(late=self.batch.busy)
            if self.batch.busy or self.growing:
                came = time.monotonic()
            if until_idle_s is not None and time.monotonic() - came > until_idle_s:
                return

    def look(self) -> None:
        """Queue files that are new or changed and have kept their size since the last scan."""
        try:
            found = gather(self.given, self.job.out, self.taken)
        except OSError:
            return  # a disk that is briefly unavailable
        self.job.about.left_aside = found.left_aside
        fresh, growing = [], False
        for source in found.spectra:
            with suppress(OSError):
                state = source.path.stat()
                mark = (state.st_size, state.st_mtime_ns)
                if self.taken.get(source.path) == mark:
                    continue
                if self.seen.get(source.path) == mark:
                    self.taken[source.path] = mark
                    fresh.append(source)
                else:
                    growing = True
                self.seen[source.path] = mark
        self.batch.add(fresh)
        self.arrived(fresh, found)
        self.growing = growing

    def write(self, *, late: bool = False) -> None:
        """Write the tables if there are new rows; `late`: not too often."""
        wait_s = max(WRITE_S, WRITE_SHARE * self.write_took) if late else 0.0
        now = time.monotonic()
        if self.job.spool.puts == self.written or now - self.wrote_at < wait_s:
            return
        puts = self.job.spool.puts
        self.job.write()
        self.written, self.wrote_at = puts, time.monotonic()
        self.write_took = self.wrote_at - now
