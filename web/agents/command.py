"""`labrun mcp`: serve agents over stdin and stdout."""

from pathlib import Path
from typing import Annotated

import typer

from ...engine.commands.options import fail, usable_lab

Folder = Annotated[
    Path | None, typer.Argument(help="Folder of the protocols; the current folder by default.")
]
Lab = Annotated[
    Path | None, typer.Option("--lab", help="The lab file; the simulated lab by default.")
]
Runs = Annotated[
    Path | None,
    typer.Option("--runs", help="Folder of the runs; `runs` beside the protocols by default."),
]


def mcp(folder: Folder = None, lab: Lab = None, runs: Runs = None) -> None:
    """Let an agent read, write, check and rehearse protocols, and start what a person has released."""
    import asyncio

    from .server import serve

    protocols = (folder or Path()).resolve()
    if not protocols.is_dir():
        fail(f"{folder} is not a folder; give the folder with your protocols")
    usable_lab(lab)
    asyncio.run(serve(protocols, (runs or protocols / "runs").resolve(), lab and lab.resolve()))
