"""`labrun schema`: a JSON Schema for this lab, with which editors complete and check protocols."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from .options import Lab, fail, say, usable_lab

Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", help="The file to write; without it, standard output."),
]


def schema(lab: Lab = None, output: Output = None) -> None:
    """Write a JSON Schema of protocols for this lab: roles, actions, parameters, units, steps."""
    from ..lab_schema.schema import schema_text

    text = schema_text(usable_lab(lab, sys.stderr))
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
