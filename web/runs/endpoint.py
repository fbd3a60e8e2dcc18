"""Talk to a live engine: send it a command, or listen to its events."""

import asyncio
import contextlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...engine.control.server import FILE, NotLive, unanswered

LONGEST_LINE = 1 << 20
CONNECT_S = 2.0


async def ask_engine(folder: Path, timeout_s: float, **request: Any) -> tuple[bool, str]:
    """The engine's answer; raises NotLive if none comes in time."""
    try:
        async with asyncio.timeout(timeout_s):
            reader, writer = await _connect(folder, **request)
            try:
                answer = json.loads(await reader.readline())
            finally:
                await _hang_up(writer)
        return bool(answer["ok"]), str(answer["text"])
    except TimeoutError as fault:
        raise unanswered(folder, request.get("verb"), timeout_s) from fault
    except (OSError, ValueError, KeyError) as fault:
        raise NotLive(f"{folder.name} is not running: no engine answers") from fault


async def listen(
    folder: Path, heard: Callable[[dict[str, Any]], None], up: Callable[[], None]
) -> None:
    """Receive every event until the engine disconnects; raises NotLive if it cannot be reached."""
    try:
        async with asyncio.timeout(CONNECT_S):
            reader, writer = await _connect(folder, verb="events")
    except (OSError, ValueError, KeyError, TimeoutError) as fault:
        raise NotLive(f"{folder.name}: no engine answers") from fault
    up()
    try:
        while (event := await _event(reader)) is not None:
            if "event" in event:
                heard(event)
    finally:
        await _hang_up(writer)


async def _event(reader: asyncio.StreamReader) -> dict[str, Any] | None:
    """The next event; None if there will be none: the engine has gone, or breaks off in a line."""
    try:
        return json.loads(await reader.readline())
    except (OSError, ValueError):
        return None


async def _connect(
    folder: Path, **request: Any
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
