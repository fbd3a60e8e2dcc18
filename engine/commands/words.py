"""`labrun words FILE`: the protocol in plain English, for the lab book."""

from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import PROBLEMS
from ..views.words.page import as_markdown, as_text, page
from .checked_protocol import checked_file
from .options import Bind, Lab, Params, say

LAYOUTS = {"text": as_text, "markdown": as_markdown}
File = Annotated[Path, typer.Argument(help="The protocol.", show_default=False)]
Format = Annotated[str, typer.Option("--format", help="text or markdown.")]


def words(
    file: File, format: Format = "text", lab: Lab = None, bind: Bind = None, param: Params = None
) -> None:
    """Describe a protocol in sentences, as a methods section would."""
    if format not in LAYOUTS:
        say(f"--format {format}: choose text or markdown")
        raise typer.Exit(PROBLEMS)
    checked = checked_file(file, lab, bind, param, needed=False)
    for line in LAYOUTS[format](page(checked)):
        print(line)
