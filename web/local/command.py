"""A command of labrun in a process of its own: until it ends, or has taken too long."""

import asyncio
import os
import signal

from ...system import WINDOWS
from ...system.process import start_python


async def labrun(*arguments: str, longest_s: float) -> tuple[int | None, list[str]]:
    """Its exit status and the lines that it said; None for one that was killed, as it took too long."""
    process = await start_python(
        "labrun.engine", *arguments,
        stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.STDOUT,
        env={**os.environ, "COLUMNS": "200", "NO_COLOR": "1"},
    )  # fmt: skip
    try:
        async with asyncio.timeout(longest_s):
            said, _ = await process.communicate()
    except TimeoutError:
        return None, []
    finally:
        if process.returncode is None:
            if WINDOWS:
                process.kill()
            else:
                os.killpg(process.pid, signal.SIGKILL)  # with its own children
            await process.wait()
    return process.returncode, said.decode(errors="replace").replace(
        "labrun: ", ""
    ).strip().splitlines()
