"""`labrun setup gantry`: from a cable to a lab file, with somebody beside the machine."""

import asyncio
from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import FAILED, PROBLEMS
from .options import say

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
        say(f"there is no setup for {kind!r}; there is one for {', '.join(KINDS)}")
        raise typer.Exit(PROBLEMS)
    if output.exists():
        say(f"{output} is there already; choose another name with -o")
        raise typer.Exit(PROBLEMS)
    try:
        asyncio.run(set_up(port, baud, output))
    except GaveUp as fault:
        say(str(fault))
        raise typer.Exit(FAILED) from None
