"""Background tasks: each has a name and an owner, and none dies in silence.

Nothing else in labrun creates a task (lint refuses it). `spawn` is for work whose owner awaits or
cancels the task; `keep` is for loops that have to go on as long as their owner does.
"""

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable, Coroutine, Iterable
from typing import Any, TypeVar

T = TypeVar("T")
LOG = logging.getLogger("labrun")
AGAIN_S = 1.0
"""How long a loop that failed rests before it begins again."""

_running: set[asyncio.Task[Any]] = set()


def spawn(
    name: str,
    work: Coroutine[Any, Any, T],
    *,
    expected: tuple[type[BaseException], ...] = (),
    among: set[asyncio.Task[T]] | None = None,
) -> asyncio.Task[T]:
    """Start work beside the caller, who keeps the task to await or cancel it.

    The task cannot be collected while it runs. An exception that ends it is logged with its
    traceback, whoever awaits it, except for the `expected` ones, which are answers. `among` are the
    caller's tasks that run: it is one of them until it has ended.
    """
    task = asyncio.get_running_loop().create_task(work, name=name)
    _running.add(task)
    task.add_done_callback(lambda done: _ended(done, expected))
    if among is not None:
        among.add(task)
        task.add_done_callback(among.discard)
    return task


def keep(
    name: str, work: Callable[[], Awaitable[None]], *, again_s: float = AGAIN_S
) -> asyncio.Task[None]:
    """Start a loop that its owner ends by cancelling it.

    When an exception ends it, that is logged with its traceback, and it begins again `again_s`
    seconds later. It ends by itself only by returning.
    """
    return spawn(name, _kept(name, work, again_s))


async def _kept(name: str, work: Callable[[], Awaitable[None]], again_s: float) -> None:
    while True:
        try:
            return await work()
        except Exception:  # whatever it was: the loop has to go on, and the log says why
            LOG.exception("%s failed; it begins again in %g s", name, again_s)
        await asyncio.sleep(again_s)


def _ended(task: asyncio.Task[Any], expected: tuple[type[BaseException], ...]) -> None:
    _running.discard(task)
    if task.cancelled():
        return
    fault = task.exception()
    if fault is not None and not isinstance(fault, expected):
        LOG.error("%s failed", task.get_name(), exc_info=fault)


async def end(*tasks: asyncio.Future[Any] | None) -> None:
    """Cancel tasks and wait until they have ended, however they end; None is no task."""
    there = [task for task in tasks if task is not None]
    for task in there:
        task.cancel()
    if there:
        await asyncio.wait(there)


async def first_of(tasks: Iterable[asyncio.Future[Any]], timeout_s: float | None = None) -> None:
    """Wait until one of the tasks has ended, or until the time is up; cancels none of them."""
    await asyncio.wait(tasks, timeout=timeout_s, return_when=asyncio.FIRST_COMPLETED)


async def in_time(work: Awaitable[object], seconds: float) -> bool:
    """Await this for so long at most, and cancel it then; whether it ended in time."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(seconds):
            await work
        return True
    return False
