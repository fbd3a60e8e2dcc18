"""`labrun check FILE...`: everything that is wrong with protocols, before anything is sent."""

from pathlib import Path
from typing import Annotated

import typer

from ..check import check_file
from ..exit_status import PROBLEMS
from ..problems.print import print_problems
from .options import Bind, Lab, Params, WrongUsage, pairs, say

FORMATS = ("text", "json", "github")
Files = Annotated[
    list[Path], typer.Argument(help="The protocols.", metavar="FILE...", show_default=False)
]
Format = Annotated[str, typer.Option("--format", help="text, json, or github (annotations).")]


def check(
    files: Files, lab: Lab = None, bind: Bind = None, param: Params = None, format: Format = "text"
) -> None:
    """Check protocols against the lab's devices; show every problem and where it is."""
    try:
        roles, params = pairs(bind, "--bind"), pairs(param, "-p")
        if format not in FORMATS:
            raise WrongUsage(f"--format {format}: choose {', '.join(FORMATS)}")
    except WrongUsage as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None
    found, ok = [], True
    for file in files:
        checked = check_file(file, lab=lab, bind=roles, params=params, needed=False)
        found += [problem for problem in checked.problems if problem not in found]
        ok = ok and checked.ok
    print_problems(found, format=format)
    if not found and format == "text":
        what = str(files[0]) if len(files) == 1 else f"{len(files)} protocols"
        print(f"{what}: no problems.")
    if not ok:
        raise typer.Exit(PROBLEMS)
