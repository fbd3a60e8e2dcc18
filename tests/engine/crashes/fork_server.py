"""A process that has imported everything and forks engines and device servers, controlled by lines of text.

It has no threads and no event loop, so that a fork is whole; a life of an engine costs a tenth of
a start from nothing. One JSON line in, one JSON line out.
"""

import json
import os
import select
import signal
import sys
import time
from pathlib import Path

import aiohttp  # noqa: F401
import socketio  # noqa: F401
import uvicorn  # noqa: F401

import labrun.engine.commands.resume
import labrun.engine.commands.run
import labrun.engine.progress.plain  # noqa: F401
from labrun.drivers.server import serve
from labrun.engine import cli
from labrun.engine.journal.history import read_history
from labrun.engine.journal.journal import Journal
from labrun.engine.run.run import Run
from labrun.engine.runner import runner
from labrun.engine.runner.compare import Unwritten
from labrun.schemas.journal import RECORD
from labrun.schemas.quantity import quantity

LIFE_S = 60
LATER_S = 0.006
KILLED = (-signal.SIGKILL, -signal.SIGALRM)


def arm(nth, when):
    """Let this process die at the n-th flush of its journal: before, torn, after, a little later.

    `later` is SIGALRM, which nobody hears: an end as abrupt as SIGKILL, with goals under way.
    """
    flush, count = Journal.flush, 0

    def deadly(journal):
        nonlocal count
        count += bool(journal._lines)
        if count == nth and journal._lines:
            if when == "torn":
                data = "".join(journal._lines).encode()
                os.write(journal._file, data[: len(data) - len(journal._lines[-1]) // 2])
            if when in ("after", "later"):
                flush(journal)
            if when == "later":
                signal.setitimer(signal.ITIMER_REAL, LATER_S)
                return
            os.kill(os.getpid(), signal.SIGKILL)
        flush(journal)

    Journal.flush = deadly


def compare_with_the_journal():
    """After every record a living run knows what one that reads the journal back knows, or dies."""
    record = Run.record

    def compared(run, one):
        record(run, one)
        if isinstance(run.journal, Unwritten):  # of a tree that only finds out where the run was
            return
        written = run.journal.path.read_bytes()
        whole = written[: written.rfind(b"\n") + 1].splitlines()
        lines = [*whole, *(line.encode() for line in run.journal._lines)]
        again = read_history([RECORD.validate_json(line) for line in lines])
        if again != run.history:
            print(
                f"{one!r}\n  living {run.history!r}\n  read   {again!r}",
                file=sys.stderr,
                flush=True,
            )
            os._exit(99)

    Run.record = compared


def engine(order):
    """One engine session, as the command line would run it."""
    compare_with_the_journal()
    if order["kill"]:
        arm(*order["kill"])
    runner.make_reports = lambda folder: ([], [])  # they are made after the last record
    sys.argv = ["labrun", *order["argv"]]
    return cli.main()


class Children:
    """The device server, which is restarted when it dies, and one engine at a time."""

    def __init__(self):
        self.settings = None
        self.server = 0

    def serve(self, order):
        self.settings = order["settings"]
        return self._serve()

    def restart(self, order):
        os.kill(self.server, signal.SIGKILL)
        os.waitpid(self.server, 0)
        return self._serve()

    def _serve(self):
        read, write = os.pipe()
        self.server = fork(lambda: serve.main([self.settings]), write, self.settings + ".log")
        os.close(write)
        with os.fdopen(read) as words:
            said = json.loads(words.readline())
        return {**said, "pid": self.server}

    def engine(self, order):
        with Path(order["log"]).open("ab") as log:
            child = fork(lambda: engine(order), log.fileno(), order["log"])
        until = time.monotonic() + LIFE_S
        while time.monotonic() < until:
            ended, status = os.waitpid(-1, os.WNOHANG)
            if ended == child:
                code = os.waitstatus_to_exitcode(status)
                return {"exit": "killed" if code in KILLED else code}
            if ended == self.server:
                self._serve()
            select.select([], [], [], 0.003)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        return {"exit": None}


def fork(work, out, log):
    """A child that does this work and nothing else; its output goes to `out`, its errors to a file."""
    child = os.fork()
    if child:
        return child
    code = 70
    try:
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.dup2(out, 1)
        os.dup2(os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644), 2)
        code = work() or 0
    except SystemExit as end:
        code = end.code or 0
    finally:
        sys.stdout.flush()
        os._exit(code)


def main():
    quantity(1, "mm")  # the registry of units, built once for all sessions
    children = Children()
    try:
        for line in sys.stdin:
            order = json.loads(line)
            print(json.dumps(getattr(children, order.pop("do"))(order)), flush=True)
    except BrokenPipeError:
        sys.stdout = None  # the controlling process is gone: there is nothing to flush to
    finally:
        if children.server:
            os.kill(children.server, signal.SIGKILL)


if __name__ == "__main__":
    main()
