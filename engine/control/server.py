"""Each run's control endpoint on loopback: other shells and the page act on the run through it.

One line of JSON is the request, one the answer: `{"token", "verb", ...}` -> `{"ok", "text"}`. The
address and the token are in `control.json` in the run's folder, readable by its owner alone.
`events` answers with the run's events, one per line, until the other side disconnects.
"""

import asyncio
import contextlib
import json
import os
import secrets
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, cast

from ...schemas.event import Event
from ...system.files import remove, write_whole
from ...system.tasks import end, spawn
from ..run.folder import is_live
from ..run.questions import WrongAnswer
from ..run.run import Run
from .control import Control, Verb

FILE = "control.json"
ANSWER_S = 30.0
"""How long another shell waits for the answer of an engine that is there."""
MAX_LINE = 64 * 1024
IDLE_S = 30.0


class ControlServer:
    """Serves one live run; `change` changes its protocol, and answers when that is done or refused."""

    def __init__(
        self, run: Run, control: Control,
        change: Callable[[dict[str, Any]], Awaitable[tuple[bool, str]]],
    ) -> None:  # fmt: skip
        self.run = run
        self.path = run.folder / FILE
        self.control = control
        self.questions = run.questions
        self.change = change
        self.token = secrets.token_urlsafe(24)
        self._server: asyncio.Server | None = None
        self._watchers: set[asyncio.Queue[str]] = set()
        self._calls: set[asyncio.Task[None]] = set()

    async def open(self) -> None:
        """Listen on a free port and write its address down."""
        self._server = await asyncio.start_server(self._accept, "127.0.0.1", 0, limit=MAX_LINE)
        port = self._server.sockets[0].getsockname()[1]
        text = json.dumps(
            {"host": "127.0.0.1", "port": port, "token": self.token, "pid": os.getpid()}
        )
        write_whole(self.path, f"{text}\n".encode(), mode=0o600, sync=False)

    async def close(self) -> None:
        """Disconnect everybody and remove the address."""
        remove(self.path)
        if self._server is not None:
            self._server.close()
        await end(*self._calls)

    def publish(self, event: Event) -> None:
        """Pass an event on to all watchers; one that is too slow loses the oldest."""
        for queue in self._watchers:
            if queue.full():
                queue.get_nowait()
            queue.put_nowait(event.model_dump_json())

    def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        spawn("answer another shell", self._call(reader, writer), among=self._calls)

    async def _call(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            async with asyncio.timeout(IDLE_S):
                line = await reader.readline()
            asked = _read(line)
            if not secrets.compare_digest(str(asked.get("token", "")), self.token):
                await _say(writer, ok=False, text="wrong token")
            elif asked.get("verb") == "events":
                await self._stream(writer)
            elif asked.get("verb") == "change":
                ok, text = await self.change(asked)
                await _say(writer, ok=ok, text=text)
            else:
                ok, text = self._do(asked)
                await _say(writer, ok=ok, text=text)
        except (TimeoutError, OSError, ValueError) as fault:
            with contextlib.suppress(OSError):
                await _say(writer, ok=False, text=str(fault) or "no request received")
        finally:
            writer.close()

    def _do(self, asked: dict[str, Any]) -> tuple[bool, str]:
        verb, by = asked.get("verb"), str(asked.get("by", "another shell"))
        if verb == "answer":
            try:
                question = self.questions.answer(
                    str(asked.get("id")), str(asked.get("choice")), by, _values(asked)
                )
            except WrongAnswer as fault:
                return False, str(fault)
            return True, f"{question.id}: {question.choice}"
        if verb in ("pause", "continue", "abort"):
            return True, self.control.ask(cast(Verb, verb), by)
        return False, f"{verb!r} is not one of pause, continue, abort, answer, change, events"

    async def _stream(self, writer: asyncio.StreamWriter) -> None:
        queue: asyncio.Queue[str] = asyncio.Queue(maxsize=10_000)
        self._watchers.add(queue)
        self.run.listen(self.publish)
        try:
            while True:
                writer.write((await queue.get() + "\n").encode())
                await writer.drain()
        finally:
            self._watchers.discard(queue)
            if not self._watchers:
                self.run.unlisten(self.publish)


def _values(asked: dict[str, Any]) -> dict[str, str]:
    values = asked.get("values")
    return {str(n): str(v) for n, v in values.items()} if isinstance(values, dict) else {}


def _read(line: bytes) -> dict[str, Any]:
    asked = json.loads(line or b"{}")
    if not isinstance(asked, dict):
        raise ValueError("a request is a JSON object on one line")
    return asked


async def _say(writer: asyncio.StreamWriter, *, ok: bool, text: str) -> None:
    writer.write((json.dumps({"ok": ok, "text": text}) + "\n").encode())
    await writer.drain()


class NotLive(Exception):
    """The run has no engine to ask."""


class Silent(NotLive):
    """Its engine is there, and has not answered in time: what it was asked may still be done."""


def unanswered(folder: Path, asked: object, timeout_s: float) -> NotLive:
    """What to say of a run that did not answer in time: its engine holds its folder, or has gone."""
    if not is_live(folder):
        return NotLive(f"{folder.name} is not running: no engine answers for it")
    return Silent(
        f"{folder.name} did not answer within {timeout_s:g} s; its engine is there, and may still "
        f"{asked}: ask again"
    )


def ask_run(
    folder: Path, request: dict[str, Any], timeout_s: float | None = ANSWER_S
) -> tuple[bool, str]:
    """Send a request to a live run from another process; raises NotLive with a sentence."""
    import socket

    try:
        where = json.loads((folder / FILE).read_text(encoding="utf-8"))
        with socket.create_connection((where["host"], where["port"]), timeout=timeout_s) as line:
            line.sendall((json.dumps({**request, "token": where["token"]}) + "\n").encode())
            with line.makefile("r", encoding="utf-8") as answers:
                answer = json.loads(answers.readline())
    except TimeoutError as fault:
        raise unanswered(folder, request.get("verb"), timeout_s or 0.0) from fault
    except (OSError, ValueError, KeyError) as fault:
        raise NotLive(f"{folder.name} is not running: no engine answers for it") from fault
    return bool(answer["ok"]), str(answer["text"])
