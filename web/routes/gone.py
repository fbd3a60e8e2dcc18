"""What takes long is given up when whoever asked for it has hung up."""

import asyncio
from collections.abc import Coroutine
from typing import Any, TypeVar

from fastapi import Request

from ..guard.refusal import Refusal

LOOK_S = 0.5
T = TypeVar("T")


async def while_there(request: Request, work: Coroutine[Any, Any, T]) -> T:
    """What the work gives; it is cancelled where nobody waits for it any more."""
    task = asyncio.create_task(work)
    try:
        while True:
            done, _ = await asyncio.wait({task}, timeout=LOOK_S)
            if done:
                return task.result()
            if await request.is_disconnected():
                raise Refusal(408, "GONE", "nobody waits for the answer any more")
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
