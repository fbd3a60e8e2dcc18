"""An engine in a separate process session: unaffected when this server stops or restarts."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

from ...engine.run.folder import LOCK, engine_of
from ...system.process import alive, apart, in_utf8

RUN = re.compile(r"^run (\S+)$", re.MULTILINE)
OURS = re.compile(r"^labrun: ", re.MULTILINE)
LAST_LINES = 12
UP_S = 60.0
"""How long an engine may take until its endpoint answers."""


def start_engine(arguments: list[str], log: Path, cwd: Path) -> "subprocess.Popen[bytes]":
    """`labrun ...` as a process with output to a file: a broken pipe would kill it when we end."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("ab") as sink:
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "labrun.engine", *arguments],
            stdin=subprocess.DEVNULL, stdout=sink, stderr=subprocess.STDOUT, cwd=cwd,
            env=in_utf8({**os.environ, "PYTHONUNBUFFERED": "1"}), **apart(),
        )  # fmt: skip


def run_told(log: Path) -> str | None:
    """The name of the run, once the engine has printed it."""
    found = RUN.search(_words(log))
    return found[1] if found is not None else None


def last_words(log: Path) -> str:
    """The engine's last output, for the user."""
    lines = [line for line in OURS.sub("", _words(log)).splitlines() if line.strip()]
    return "\n".join(lines[-LAST_LINES:]) or "the engine ended without any output"


def began_at(folder: Path) -> float | None:
    """When an engine took a run's folder, if it is alive but does not answer yet; else None.

    For a minute only: later its process id may belong to another program.
    """
    try:
        took = (folder / LOCK).stat().st_mtime
    except OSError:
        return None
    return took if time.time() - took < UP_S and alive(engine_of(folder)) else None


def _words(log: Path) -> str:
    try:
        return log.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
