"""Commands that run once: each key is on disk before its command begins, the answer after."""

import asyncio
import sqlite3
import time
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from fastapi import Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException

from ..local.refusal import Refusal, as_response

KEPT_S = 24 * 3600.0
WAIT_S = 30.0
REPLAYED = "Idempotent-Replay"


class UnreadableKeys(Exception):
    """The commands of the last day are not known; the text says what to do."""


@dataclass(frozen=True, slots=True)
class Known:
    """What is known of a key; `status` is None while the outcome is unknown."""

    means: str
    status: int | None
    body: bytes


class Keys:
    """The keys of commands with their answers, in a small database; raises UnreadableKeys."""

    def __init__(self, path: Path) -> None:
        try:
            self._base = _opened(path)
            self.forget_old()
        except sqlite3.DatabaseError as fault:
            raise UnreadableKeys(
                f"{path} cannot be read: {fault}. It holds which commands were done within the last day, "
                f"so that none is done twice. Put it back from a backup; or, where no program will send "
                f"one of them again (the page never does), move it away with its -wal and start again"
            ) from fault
        self.under_way: dict[str, asyncio.Event] = {}

    def close(self) -> None:
        """Close the file."""
        self._base.close()

    def forget_old(self) -> None:
        """Drop what is older than a day."""
        self._base.execute("DELETE FROM commands WHERE at < ?", (time.time() - KEPT_S,))

    def known(self, key: str) -> Known | None:
        """What is known of a key."""
        query = "SELECT means, status, body FROM commands WHERE key = ?"
        row = self._base.execute(query, (key,)).fetchone()
        return None if row is None else Known(*row)

    def begin(self, key: str, means: str) -> None:
        """Store a key on disk before anything is done."""
        values = (key, means, time.time())
        self._base.execute("INSERT INTO commands VALUES (?, ?, NULL, NULL, ?)", values)
        self.under_way[key] = asyncio.Event()

    def end(self, key: str, answer: Response | None) -> None:
        """Store its answer; None if nothing was done, which frees the key."""
        if answer is None:
            self._base.execute("DELETE FROM commands WHERE key = ?", (key,))
        else:
            values = (answer.status_code, bytes(answer.body), key)
            self._base.execute("UPDATE commands SET status = ?, body = ? WHERE key = ?", values)
        self.leave(key)

    def leave(self, key: str) -> None:
        """Wake those who wait for this key."""
        waiting = self.under_way.pop(key, None)
        if waiting is not None:
            waiting.set()


class CommandRoute(APIRoute):
    """A route that runs each key once, even across a restart of the server."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """FastAPI's handler wrapped with the key."""
        handle = super().get_route_handler()

        async def once(request: Request) -> Response:
            key = request.headers.get("idempotency-key")
            if key is None or not 8 <= len(key) <= 128:
                return await handle(request)  # its own dependencies decide whether that is allowed
            keys: Keys = request.app.state.app_state.keys
            means = await _means(request)
            try:
                known = await _known(keys, key, means)
                if known is not None:
                    return known
                keys.begin(key, means)
            except sqlite3.Error as fault:
                return as_response(_not_kept(fault))
            try:
                answer = await handle(request)
            except (Refusal, HTTPException, RequestValidationError) as refusal:
                keys.end(key, None)
                return as_response(refusal)
            except BaseException:  # it is unknown how far it got: the key stays used
                keys.leave(key)
                raise
            keys.end(key, answer)
            return answer

        return once


def _opened(path: Path) -> sqlite3.Connection:
    base = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    try:
        base.execute("PRAGMA journal_mode=WAL")
        base.execute("PRAGMA synchronous=FULL")
        base.execute(
            "CREATE TABLE IF NOT EXISTS commands "
            "(key TEXT PRIMARY KEY, means TEXT, status INTEGER, body BLOB, at REAL)"
        )
        (said,) = base.execute("PRAGMA quick_check(1)").fetchone()
        if said != "ok":
            raise sqlite3.DatabaseError(said)
    except BaseException:  # raised again: nobody else would close it
        base.close()
        raise
    return base


def _not_kept(fault: sqlite3.Error) -> Refusal:
    """A command that could not be noted is not begun."""
    return Refusal(
        507, "NOT_KEPT", f"nothing was done: the command cannot be noted in commands.sqlite: {fault}",
        "make room on the disk, or start labrun web again: it says what to do with a damaged file",
    )  # fmt: skip


async def _means(request: Request) -> str:
    """What a command requests: the same key for another command is the sender's error."""
    body = await request.body()
    head = f"{request.method} {request.url.path}?{request.url.query}\n"
    return sha256(head.encode() + body).hexdigest()


async def _known(keys: Keys, key: str, means: str) -> Response | None:
    """The earlier answer of a key; waits if the command is still being done."""
    async with asyncio.timeout(WAIT_S):
        while (waiting := keys.under_way.get(key)) is not None:
            await waiting.wait()
    known = keys.known(key)
    if known is None:
        return None
    if known.means != means:
        return as_response(
            Refusal(422, "KEY_USED", "this Idempotency-Key was used for another command")
        )
    if known.status is None:
        return as_response(
            Refusal(
                409, "UNKNOWN", "it is unknown whether this was done: the server stopped meanwhile",
                "check the device or the run; the command is not repeated",
            )
        )  # fmt: skip
    headers = {"content-type": "application/json", REPLAYED: "true"}
    return Response(known.body, known.status, headers)
