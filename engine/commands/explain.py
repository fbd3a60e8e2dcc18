"""`labrun explain FILE`: the protocol as P = [A1, ..., AT], with sizes and counts."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from ..check import check_file
from ..exit_status import PROBLEMS
from ..problems.print import print_problems
from ..views.explain import explain_protocol
from .options import Bind, Lab, Params, WrongUsage, pairs, say

File = Annotated[Path, typer.Argument(help="The protocol.", show_default=False)]


def explain(file: File, lab: Lab = None, bind: Bind = None, param: Params = None) -> None:
    """Show what a protocol does, in order: its action sets, how often, on which devices."""
    try:
        roles, params = pairs(bind, "--bind"), pairs(param, "-p")
    except WrongUsage as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None
    checked = check_file(file, lab=lab, bind=roles, params=params, needed=False)
    if checked.problems:
        print_problems(checked.problems, file=sys.stderr)
    if not checked.ok:
        raise typer.Exit(PROBLEMS)
    for line in explain_protocol(checked):
        print(line)
