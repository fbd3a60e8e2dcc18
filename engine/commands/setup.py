"""`labrun setup gantry`: from a cable to a lab file, with somebody beside the machine."""

import asyncio
import os
import sys
from collections.abc import Coroutine
from pathlib import Path
from typing import Annotated, Any

import typer

from ..exit_status import CTRL_C, FAILED
from .options import fail, failing_on, say

KINDS = ("gantry",)


def setup(
    kind: Annotated[str, typer.Argument(metavar="gantry", help="What to set up.")],
    port: Annotated[
        str | None, typer.Option("--port", help="Its port; without it each one is tried.")
    ] = None,
    baud: Annotated[int, typer.Option("--baud")] = 115200,
    output: Annotated[Path, typer.Option("-o", "--output", help="The lab file to write.")] = Path(
        "lab.yaml"
    ),
) -> None:
    """Find a gantry, read its settings, see which way its axes go, and write its lab file."""
    from .setup_gantry import GaveUp, set_up

    if kind not in KINDS:
        fail(f"there is no setup for {kind!r}; there is one for {', '.join(KINDS)}")
    if output.exists():
        fail(f"{output} is there already; choose another name with -o")
    with failing_on(GaveUp, status=FAILED):
        asyncio.run(_until_end(set_up(port, baud, output), output))


async def _until_end(work: Coroutine[Any, Any, None], output: Path) -> None:
    """Set up; a signal that asks to end stops what moves first, whoever is still asked something."""
    from ...system.signals import on_end
    from ...system.tasks import spawn
    from .setup_gantry import GaveUp

    asked: list[str] = []
    setting_up = spawn("set up", work, expected=(GaveUp,))

    def end(by: str) -> None:
        asked.append(by)
        setting_up.cancel()

    deaf = on_end(end)
    try:
        await asyncio.wait({setting_up})
    finally:
        deaf()
    if setting_up.cancelled():
        say(f"{asked[0]}: stopped; {output} was not written")
        sys.stdout.flush()
        os._exit(
            CTRL_C if asked[0] == "Ctrl-C" else FAILED
        )  # a thread may still wait for an answer
    setting_up.result()
