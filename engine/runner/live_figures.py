"""Figures that grow during a run, drawn by a process beside the engine.

Makers registered as `labrun.live` are called every few seconds: a maker is a function from the run's
folder to figures by file name. The engine only starts one process, and only in runs that last long
enough to be watched; what goes wrong there does not affect the run.
"""

import asyncio
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from importlib.metadata import entry_points

from ...system.process import start_python
from ...system.tasks import end, in_time, spawn
from ..run.run import Run
from .draw_live import GROUP

EVERY_S = 10.0
END_S = 2.0


@asynccontextmanager
async def live_figures(
    run: Run, wanted: bool = True, every_s: float = EVERY_S
) -> AsyncIterator[None]:
    """While the body runs, figures in the run's folder are redrawn every `every_s` seconds."""
    if not wanted:
        yield
        return
    following = spawn("draw live figures", _follow(run, every_s))
    try:
        yield
    finally:
        await end(following)


async def _follow(run: Run, every_s: float) -> None:
    await asyncio.sleep(every_s)
    if not await asyncio.to_thread(entry_points, group=GROUP):
        return
    try:
        process = await start_python(
            "labrun.engine.runner.draw_live", str(run.folder), f"{every_s:g}",
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip
    except OSError:
        return  # the process cannot start: the report draws the figures at the end
    try:
        assert process.stdout is not None
        while name := (await process.stdout.readline()).decode().strip():
            run.log(f"{run.folder / name} is updated during the run")
    finally:
        await _end(process)


async def _end(process: asyncio.subprocess.Process) -> None:
    """It ends with its input, but never in the middle of a file."""
    assert process.stdin is not None
    process.stdin.close()
    if not await in_time(process.wait(), END_S):
        with suppress(ProcessLookupError):
            process.kill()
        await process.wait()
