"""`labrun explain FILE`: the protocol as P = [A1, ..., AT], with sizes and counts."""

from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import PROBLEMS
from ..views.explain import explain_protocol
from .options import Bind, Lab, Params
from .partial_protocol import checked_and_told

File = Annotated[Path, typer.Argument(help="The protocol.", show_default=False)]


def explain(file: File, lab: Lab = None, bind: Bind = None, param: Params = None) -> None:
    """Show what a protocol does, in order: its action sets, how often, on which devices."""
    checked = checked_and_told(file, lab, bind, param)
    if not checked.ok:
        raise typer.Exit(PROBLEMS)
    for line in explain_protocol(checked):
        print(line)
