"""A run in a separate engine process: it continues after its parent has gone."""

import asyncio
import json
import subprocess
from collections.abc import AsyncGenerator, Mapping
from pathlib import Path

from pydantic import ValidationError

from ....engine.control.server import NotLive, ask_run
from ....schemas.event import Event
from ...runs.engine import start_engine

LOOK_S = 0.03
LAST_LINES = 12


class EngineProcess:
    """`labrun run ... --json` as a process, and its events.

    Its output goes to a file: a broken pipe would kill the engine when we end. Arguments are passed
    as a list; no shell is involved.
    """

    def __init__(self, process: "subprocess.Popen[bytes]", log: Path) -> None:
        self.process = process
        self.log = log

    async def events(self) -> AsyncGenerator[Event, None]:
        """Its events until it has ended."""
        with self.log.open("rb") as words:
            rest = b""
            while True:
                over = self.process.poll() is not None
                rest += words.read()
                *lines, rest = rest.split(b"\n")
                for line in lines:
                    event = _event(line)
                    if event is not None:
                        yield event
                if over:
                    return
                await asyncio.sleep(LOOK_S)

    def last_words(self) -> str:
        """Its last output that is not an event, for the user."""
        text = self.log.read_text(encoding="utf-8", errors="replace")
        lines = [
            line for line in text.splitlines() if line.strip() and _event(line.encode()) is None
        ]
        return "\n".join(_problem(line) for line in lines[-LAST_LINES:])

    async def abort(self, folder: Path, by: str) -> None:
        """Request an abort as another shell would, until it is accepted or the run has ended."""
        while self.process.poll() is None:
            try:
                await asyncio.to_thread(ask_run, folder, {"verb": "abort", "by": by})
                return
            except NotLive:  # it has reported its name, but does not listen yet
                await asyncio.sleep(LOOK_S)


def start_run(
    protocol: Path, options: Mapping[str, Mapping[str, str]], lab: Path, runs: Path, log: Path
) -> EngineProcess:
    """Start a run; raises OSError. `options`: `-p`, `--bind` and `--answer` with their pairs."""
    arguments = ["run", "--json", "--lab", str(lab), "--runs", str(runs)]
    for option, pairs in options.items():
        arguments += [part for name, value in pairs.items() for part in (option, f"{name}={value}")]
    process = start_engine([*arguments, "--", str(protocol)], log, protocol.parent)
    return EngineProcess(process, log)


def _event(line: bytes) -> Event | None:
    try:
        return Event.model_validate_json(line)
    except ValidationError:
        return None


def _problem(line: str) -> str:
    """A problem of `--json` as a sentence; anything else as it is."""
    try:
        hear = json.loads(line)
        return f"{hear['file']}:{hear['line']}: {hear['code']}: {hear['message']}"
    except (ValueError, TypeError, KeyError):
        return line.removeprefix("labrun: ")
