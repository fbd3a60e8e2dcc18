"""Commands that are done once: the key of each is on disk before it begins, its answer after."""

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

from .refusal import Refusal, as_response

KEPT_S = 24 * 3600.0
WAIT_S = 30.0
REPLAYED = "Idempotent-Replay"


@dataclass(frozen=True, slots=True)
class Known:
    """What is known of a key; `status` is None while nobody can say how it ended."""

    means: str
    status: int | None
    body: bytes


class Keys:
    """The keys of commands with their answers, in a small database."""

    def __init__(self, path: Path) -> None:
        self._base = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
        self._base.execute("PRAGMA journal_mode=WAL")
        self._base.execute("PRAGMA synchronous=FULL")
        self._base.execute(
            "CREATE TABLE IF NOT EXISTS commands "
            "(key TEXT PRIMARY KEY, means TEXT, status INTEGER, body BLOB, at REAL)"
        )
        self.under_way: dict[str, asyncio.Event] = {}
        self.forget_old()

    def close(self) -> None:
        """Let go of the file."""
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
        """On disk before anything is done."""
        values = (key, means, time.time())
        self._base.execute("INSERT INTO commands VALUES (?, ?, NULL, NULL, ?)", values)
        self.under_way[key] = asyncio.Event()

    def end(self, key: str, answer: Response | None) -> None:
        """Its answer; None where nothing was done, so that the key is free again."""
        if answer is None:
            self._base.execute("DELETE FROM commands WHERE key = ?", (key,))
        else:
            values = (answer.status_code, bytes(answer.body), key)
            self._base.execute("UPDATE commands SET status = ?, body = ? WHERE key = ?", values)
        self.leave(key)

    def leave(self, key: str) -> None:
        """Whoever waits for this key may look at it again."""
        waiting = self.under_way.pop(key, None)
        if waiting is not None:
            waiting.set()


class CommandRoute(APIRoute):
    """A route that does each key once, also over a restart of the server."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """The handler of FastAPI with the key around it."""
        handle = super().get_route_handler()

        async def once(request: Request) -> Response:
            key = request.headers.get("idempotency-key")
            if key is None or not 8 <= len(key) <= 128:
                return await handle(request)  # its own dependencies say whether that will do
            keys: Keys = request.app.state.site.keys
            means = await _means(request)
            known = await _known(keys, key, means)
            if known is not None:
                return known
            keys.begin(key, means)
            try:
                answer = await handle(request)
            except (Refusal, HTTPException, RequestValidationError) as refusal:
                keys.end(key, None)
                return as_response(refusal)
            except BaseException:
                keys.leave(key)  # nobody knows how far it came: the key stays used
                raise
            keys.end(key, answer)
            return answer

        return once


async def _means(request: Request) -> str:
    """What a command asks for: the same key with another meaning is a fault of its sender."""
    body = await request.body()
    head = f"{request.method} {request.url.path}?{request.url.query}\n"
    return sha256(head.encode() + body).hexdigest()


async def _known(keys: Keys, key: str, means: str) -> Response | None:
    """The answer that a key was given before; waits for one that is being done."""
    waiting = keys.under_way.get(key)
    if waiting is not None:
        async with asyncio.timeout(WAIT_S):
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
                409, "UNKNOWN", "nobody knows whether this was done: the server ended meanwhile",
                "look at the device or the run; it is not done again",
            )
        )  # fmt: skip
    headers = {"content-type": "application/json", REPLAYED: "true"}
    return Response(known.body, known.status, headers)
