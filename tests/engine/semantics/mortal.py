"""Engines that die where a test wants them to: forked from a process that has imported everything.

One JSON line in, one JSON line out. A moment is written as `KIND PATH`: a record of the journal
that has just become durable (`ended main/scan/2/shoot/1`), `feedback PATH` for an action under way, or
`copies`: those of a changed protocol lie in the run's folder, and no record makes them count.
"""

import json
import os
import re
import signal
import sys
from pathlib import Path
from threading import Thread

import aiohttp  # noqa: F401
import socketio  # noqa: F401

import labrun.engine.commands.run as run_command
import labrun.engine.progress.plain  # noqa: F401
import labrun.engine.runner.change as change_of_a_run
from labrun.engine import cli
from labrun.engine.control.server import ask_run
from labrun.engine.journal.journal import Journal
from labrun.engine.runner import runner
from labrun.schemas.quantity import quantity

LIFE_S = 30


def moment(line):
    """A line of the journal as `KIND PATH`, the run's name left out."""
    record = json.loads(line)
    kind = record["kind"]
    if kind in ("goal", "ended"):
        return f"{kind} {record['id'].partition('/')[2]}"
    if kind == "iteration":
        return f"{kind} {record['loop']}/{record['key']}"
    return f"{kind} {record.get('path') or record.get('loop') or record.get('phase') or ''}"


def die():
    os.kill(os.getpid(), signal.SIGKILL)


def doom(pattern, change):
    """Let this process die when a moment like this has come; `change` it at an event, if anything."""
    flush, keep_change = Journal.flush, change_of_a_run.keep_change

    def deadly_copies(*args):
        kept = keep_change(*args)
        if pattern == "copies":
            die()
        return kept

    def deadly(journal):
        lines = list(journal._lines)
        flush(journal)
        if any(re.search(pattern, moment(line)) for line in lines):
            die()

    def watch(run, control):
        def told(event):
            if change and re.search(change["at"], f"{event.event} {event.state} {event.path}"):
                asked = {"verb": "change", "file": change["file"], "by": "Ada"}
                Thread(target=ask_run, args=(run.folder, asked, None), daemon=True).start()
                change.clear()
            if event.event == "feedback" and re.search(pattern, f"feedback {event.path}"):
                die()

        return told

    Journal.flush, change_of_a_run.keep_change = deadly, deadly_copies
    run_command.watcher = lambda json: watch


def session(order):
    """One life of an engine, as the command line would live it."""
    doom(order["until"], order["change"])
    signal.alarm(LIFE_S)
    runner.make_reports = lambda folder: ([], [])
    sys.argv = ["labrun", *order["argv"]]
    return cli.main()


def fork(order):
    """Live in a child; how it ended."""
    child = os.fork()
    if not child:
        code = 70
        try:
            words = os.open(order["log"], os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
            os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
            os.dup2(words, 1)
            os.dup2(words, 2)
            code = session(order) or 0
        except SystemExit as end:
            code = end.code or 0
        finally:
            sys.stdout.flush()
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def main():
    quantity(1, "mm")  # the registry of units, built once for all lives
    for line in sys.stdin:
        order = json.loads(line)
        answer = {"exit": fork(order), "words": Path(order["log"]).read_text()}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
