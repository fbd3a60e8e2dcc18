"""Options that the commands of this room share."""

from pathlib import Path
from typing import Annotated

import typer

from ...engine.commands.options import fail

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
Port = Annotated[int, typer.Option("--port", min=0, max=65535, help="0 picks a free port.")]
Host = Annotated[str, typer.Option("--host", help="Address to listen on.")]
TokenFile = Annotated[
    Path | None, typer.Option("--token-file", help="The file that holds it, unseen by `ps`.")
]


def protocol_folder(folder: Path | None) -> Path:
    """The folder that holds the protocols; ends the command where there is none."""
    protocols = (folder or Path()).resolve()
    if not protocols.is_dir():
        fail(f"{folder} is not a folder; give the folder with your protocols")
    return protocols
