"""`labrun check FILE...`: everything that is wrong with protocols, before anything is sent."""

from pathlib import Path
from typing import Annotated

import typer

from .check_files import check_files
from .options import Bind, Lab, Params, fail, pairs

FORMATS = ("text", "json", "github")
Files = Annotated[
    list[Path], typer.Argument(help="The protocols.", metavar="FILE...", show_default=False)
]
Format = Annotated[str, typer.Option("--format", help="text, json, or github (annotations).")]


def check(
    files: Files, lab: Lab = None, bind: Bind = None, param: Params = None, format: Format = "text"
) -> None:
    """Check protocols against the lab's devices; show every problem and where it is."""
    roles, params = pairs(bind, "--bind"), pairs(param, "-p")
    if format not in FORMATS:
        fail(f"--format {format}: choose {', '.join(FORMATS)}")
    raise typer.Exit(check_files(files, lab=lab, bind=roles, params=params, format=format))
