"""Check a protocol file for a command: problems are shown, and an error ends the command."""

import sys
from pathlib import Path

import typer

from ..check import Checked, check_file
from ..exit_status import PROBLEMS
from ..problems.print import print_problems
from .options import WrongUsage, pairs, say


def checked_file(
    file: Path, lab: Path | None, bind: list[str] | None, param: list[str] | None,
    *, needed: bool = True, json: bool = False,
) -> Checked:  # fmt: skip
    """The checked protocol; problems go to stderr, and an error ends the command with status 2."""
    roles, params = name_values(bind, "--bind"), name_values(param, "-p")
    checked = check_file(file, lab=lab, bind=roles, params=params, needed=needed)
    if checked.problems:
        print_problems(checked.problems, format="json" if json else "text", file=sys.stderr)
    if not checked.ok:
        raise typer.Exit(PROBLEMS)
    return checked


def name_values(texts: list[str] | None, option: str) -> dict[str, str]:
    """`NAME=VALUE` options as a dictionary; one in another form ends the command."""
    try:
        return pairs(texts, option)
    except WrongUsage as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None
