"""A folder of tables being written: nothing in it changes until everything is ready."""

import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

from ...system.files import put
from ..tables.rows import unpacked
from ..tables.write import file_names, write_tables
from .gather import is_reduced
from .source import natural
from .spool import Spool
from .summary import NAME, Circumstances, Counts, counts_of, summary_of, write_summary

MEANWHILE = ".reducing-"


class NotOurs(ValueError):
    """The folder cannot be used for the tables; the message says why and what to do."""


class Job:
    """Rows on their way into `out`."""

    def __init__(self, out: Path, meanwhile: Path, about: Circumstances) -> None:
        self.out = out
        self.meanwhile = meanwhile
        self.about = about
        self.began = time.monotonic()
        self.spool = Spool(meanwhile / "rows")

    def write(self) -> Counts:
        """Rewrite all tables from the rows so far, and rename them into place together."""
        names = sorted(self.spool.kept, key=natural)
        written = write_tables(
            ((name, unpacked(self.spool.rows(name))) for name in names), self.meanwhile
        )
        counts = counts_of(self.spool)
        self.about.seconds = time.monotonic() - self.began
        summary = summary_of(self.spool, counts, self.about)
        written.append(write_summary(summary, self.meanwhile))
        for path in written:
            put(path, self.out / path.name)
        return counts


@contextmanager
def job_in(out: Path, about: Circumstances) -> Iterator[Job]:
    """Open a job in `out`, created if missing; incomplete work is removed at the end.

    Raises NotOurs if files not written by a reduction would be overwritten, OSError if the folder
    cannot be written to.
    """
    _check(out)
    made = not out.exists()
    out.mkdir(parents=True, exist_ok=True)
    meanwhile = Path(tempfile.mkdtemp(prefix=MEANWHILE, dir=out))
    about.started = datetime.now(UTC)
    job = Job(out, meanwhile, about)
    try:
        yield job
    finally:
        job.spool.close()
        shutil.rmtree(meanwhile, ignore_errors=True)
        if made:
            with suppress(OSError):
                out.rmdir()  # only if empty: a folder with tables stays


def _check(out: Path) -> None:
    if out.exists() and not out.is_dir():
        raise NotOurs(f"{out} is a file, but the tables need a folder; name one with -o")
    taken = [name for name in (*file_names(), NAME) if (out / name).exists()]
    if taken and not is_reduced(out):
        raise NotOurs(
            f"{out} holds {taken[0]}, which no reduction of labrun is recorded as writing; "
            "name another folder with -o"
        )
