"""A protocol file for a command that draws it: all that can be understood, despite problems."""

import sys
from pathlib import Path

import typer

from ..check import Checked, check_file
from ..exit_status import PROBLEMS
from ..problems.print import print_problems
from .options import WrongUsage, pairs, say

STOPPING = ("E1", "E208", "E209", "E21", "E22")
"""What hides the meaning of a protocol: its shape, its devices, its parameters."""


def checked_as_far_as(
    file: Path, lab: Path | None, bind: list[str] | None, param: list[str] | None
) -> Checked:
    """The checked protocol; problems are shown, but only a structural one ends the command.

    Points outside the bench are exactly what a preview should show.
    """
    checked = checked_and_told(file, lab, bind, param)
    stopped = any(
        one.severity == "error" and one.code.startswith(STOPPING) for one in checked.problems
    )
    if stopped or checked.protocol is None or checked.survey is None:
        raise typer.Exit(PROBLEMS)
    return checked


def checked_and_told(
    file: Path, lab: Path | None, bind: list[str] | None, param: list[str] | None
) -> Checked:
    """The checked protocol, parameters or not; its problems are shown."""
    try:
        roles, params = pairs(bind, "--bind"), pairs(param, "-p")
    except WrongUsage as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None
    checked = check_file(file, lab=lab, bind=roles, params=params, needed=False)
    if checked.problems:
        print_problems(checked.problems, file=sys.stderr)
    return checked
