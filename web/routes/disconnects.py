"""Long work is abandoned when its requester has disconnected."""

import asyncio
from collections.abc import Coroutine
from typing import Any, TypeVar

from fastapi import Request

from ...system.tasks import end, spawn
from ..local.refusal import Refusal

LOOK_S = 0.5
T = TypeVar("T")


async def while_there(request: Request, work: Coroutine[Any, Any, T]) -> T:
    """The result of the work, which is cancelled if nobody waits for it any more."""
    task = spawn(f"{request.method} {request.url.path}", work, expected=(Refusal,))
    try:
        while True:
            done, _ = await asyncio.wait({task}, timeout=LOOK_S)
            if done:
                return task.result()
            if await request.is_disconnected():
                raise Refusal(408, "GONE", "the requester has disconnected")
    finally:
        await end(task)
