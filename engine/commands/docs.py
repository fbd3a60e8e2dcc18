"""`labrun docs`: the manual, which is a folder in this installation and needs no connection."""

from typing import Annotated

import typer

from .options import fail, say

NoBrowser = Annotated[
    bool, typer.Option("--no-browser", help="Print where it is, and open nothing.")
]


def docs(no_browser: NoBrowser = False) -> None:
    """Open the manual in a browser, offline, and print where it is."""
    import webbrowser

    from ...system.page import DOCS, HOW_DOCS

    index = DOCS / "index.html"
    if not index.is_file():
        fail(f"the manual is not in this installation: {HOW_DOCS}")
    print(index)
    if not no_browser and not webbrowser.open(index.as_uri()):
        say("no browser was found; open that file in one")
