"""Speak to a live engine: ask it for something, or listen to its events."""

import asyncio
import contextlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...engine.control_server import FILE, NotLive

LONGEST_LINE = 1 << 20
CONNECT_S = 2.0


async def ask_engine(folder: Path, timeout_s: float, **request: str) -> tuple[bool, str]:
    """What the engine answers; raises NotLive where none does in time."""
    try:
        async with asyncio.timeout(timeout_s):
            reader, writer = await _connect(folder, **request)
            try:
                answer = json.loads(await reader.readline())
            finally:
                await _hang_up(writer)
        return bool(answer["ok"]), str(answer["text"])
    except (OSError, ValueError, KeyError, TimeoutError) as fault:
        raise NotLive(f"{folder.name} is not running: no engine answers for it") from fault


async def listen(
    folder: Path, heard: Callable[[dict[str, Any]], None], up: Callable[[], None]
) -> None:
    """Hear every event until the engine hangs up; raises NotLive where it cannot be reached."""
    try:
        async with asyncio.timeout(CONNECT_S):
            reader, writer = await _connect(folder, verb="events")
    except (OSError, ValueError, KeyError, TimeoutError) as fault:
        raise NotLive(f"{folder.name}: no engine answers") from fault
    up()
    try:
        with contextlib.suppress(OSError, ValueError):
            while line := await reader.readline():
                event = json.loads(line)
                if "event" in event:
                    heard(event)
    finally:
        await _hang_up(writer)


async def _connect(
    folder: Path, **request: str
) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    where = json.loads((folder / FILE).read_text(encoding="utf-8"))
    reader, writer = await asyncio.open_connection(where["host"], where["port"], limit=LONGEST_LINE)
    writer.write((json.dumps({**request, "token": where["token"]}) + "\n").encode())
    await writer.drain()
    return reader, writer


async def _hang_up(writer: asyncio.StreamWriter) -> None:
    writer.close()
    with contextlib.suppress(OSError):
        await writer.wait_closed()
