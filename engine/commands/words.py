"""`labrun words FILE`: the protocol in plain English, for the lab book."""

from typing import Annotated

import typer

from ..views.words.page import as_markdown, as_text, page
from .checked_protocol import checked_file
from .options import Bind, File, Lab, Params, fail

LAYOUTS = {"text": as_text, "markdown": as_markdown}
Format = Annotated[str, typer.Option("--format", help="text or markdown.")]


def words(
    file: File, format: Format = "text", lab: Lab = None, bind: Bind = None, param: Params = None
) -> None:
    """Describe a protocol in sentences, as a methods section would."""
    if format not in LAYOUTS:
        fail(f"--format {format}: choose text or markdown")
    checked = checked_file(file, lab, bind, param, needed=False)
    for line in LAYOUTS[format](page(checked)):
        print(line)
