"""`labrun schema`: a JSON Schema for this lab, with which editors complete and check protocols."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import PROBLEMS
from ..lab.lab import load_lab
from ..problems.print import print_problems
from .options import Lab, fail, say

Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", help="The file to write; without it, standard output."),
]


def schema(lab: Lab = None, output: Output = None) -> None:
    """Write a JSON Schema of protocols for this lab: roles, actions, parameters, units, steps."""
    from ..lab_schema.schema import schema_text

    loaded, problems = load_lab(lab)
    if problems:
        print_problems(problems, file=sys.stderr)
    if loaded is None or any(problem.severity == "error" for problem in problems):
        raise typer.Exit(PROBLEMS)
    text = schema_text(loaded)
    if output is None:
        typer.echo(text, nl=False)
        return
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(text, encoding="utf-8", newline="\n")
    except OSError as fault:
        fail(f"{output} cannot be written: {fault.strerror}; name another file with -o")
    there = output.as_posix() if output.is_absolute() else f"./{output.as_posix()}"
    say(f"{output} written; start a protocol in this folder with this line:")
    typer.echo(f"# yaml-language-server: $schema={there}", err=True)
