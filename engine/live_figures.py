"""Figures that grow while a run goes on, drawn by a process beside the engine.

Whoever registered as `labrun.live` is asked every few seconds: a maker is a function from the run's
folder to figures by file name. The engine pays for one start of a process, and only in runs that
last long enough to be looked at; what goes wrong there costs the run nothing.
"""

import asyncio
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from importlib.metadata import entry_points
from typing import Any

from .draw_live import GROUP
from .run import Run

EVERY_S = 10.0
END_S = 2.0


@asynccontextmanager
async def live_figures(
    run: Run, wanted: bool = True, every_s: float = EVERY_S
) -> AsyncIterator[None]:
    """While the body runs, figures in the run's folder are drawn anew every `every_s` seconds."""
    if not wanted:
        yield
        return
    following = asyncio.create_task(_follow(run, every_s))
    try:
        yield
    finally:
        following.cancel()
        with suppress(asyncio.CancelledError):
            await following


async def _follow(run: Run, every_s: float) -> None:
    await asyncio.sleep(every_s)
    if not await asyncio.to_thread(entry_points, group=GROUP):
        return
    try:
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-P", "-m", "labrun.engine.draw_live", str(run.folder), f"{every_s:g}",
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, **_apart(),
        )  # fmt: skip
    except OSError:
        return  # no room for another process: the report draws the figures in the end
    try:
        assert process.stdout is not None
        while name := (await process.stdout.readline()).decode().strip():
            run.log(f"{run.folder / name} grows with the run")
    finally:
        await _end(process)


async def _end(process: asyncio.subprocess.Process) -> None:
    """It goes when its input ends, but never between the halves of a file."""
    assert process.stdin is not None
    process.stdin.close()
    try:
        async with asyncio.timeout(END_S):
            await process.wait()
    except TimeoutError:
        with suppress(ProcessLookupError):
            process.kill()
        await process.wait()


def _apart() -> dict[str, Any]:
    """Ctrl-C in the terminal is for the engine, which ends this in order."""
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"start_new_session": True}
