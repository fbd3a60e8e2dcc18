"""An engine in a session of its own: it does not notice when this server goes, or comes again."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

from ...drivers.presence import alive

RUN = re.compile(r"^run (\S+)$", re.MULTILINE)
OURS = re.compile(r"^labrun: ", re.MULTILINE)
LAST_LINES = 12
UP_S = 60.0
"""So long an engine may take until it is heard."""
FLAGS = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)


def start_engine(arguments: list[str], log: Path, cwd: Path) -> "subprocess.Popen[bytes]":
    """`labrun ...` as a process whose words go to a file: a pipe would end with us, and it with it."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("ab") as sink:
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "labrun.engine", *arguments],
            stdin=subprocess.DEVNULL, stdout=sink, stderr=subprocess.STDOUT, cwd=cwd,
            env={**os.environ, "PYTHONUNBUFFERED": "1"}, start_new_session=sys.platform != "win32",
            creationflags=FLAGS,
        )  # fmt: skip


def run_told(log: Path) -> str | None:
    """The name of the run, once the engine has said it."""
    found = RUN.search(_words(log))
    return found[1] if found is not None else None


def last_words(log: Path) -> str:
    """What the engine said at last, for a person."""
    lines = [line for line in OURS.sub("", _words(log)).splitlines() if line.strip()]
    return "\n".join(lines[-LAST_LINES:]) or "the engine ended without a word"


def began_at(folder: Path) -> float | None:
    """When an engine took a run's folder that is there still but is not heard yet; else None.

    For a minute only: afterwards its process number may be that of somebody else.
    """
    lock = folder / "engine.lock"
    try:
        took = lock.stat().st_mtime
        pid = int(lock.read_text(encoding="ascii"))
    except (OSError, ValueError):
        return None
    return took if time.time() - took < UP_S and alive(pid) else None


def _words(log: Path) -> str:
    try:
        return log.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
