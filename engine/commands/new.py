"""`labrun new NAME`: a commented protocol to start from."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from ..check import check_text
from ..exit_status import PROBLEMS
from ..new import TEMPLATES, CannotMake, new_protocol, protocol_name, template_text
from ..print_problems import print_problems
from .options import Lab, say

Name = Annotated[str, typer.Argument(help="What the protocol is called.", show_default=False)]
Template = Annotated[
    str, typer.Option("--template", help=f"What it begins with: {', '.join(TEMPLATES)}.")
]


def new(name: Name, template: Template = "grid_scan", lab: Lab = None) -> None:
    """Write NAME.yaml, a commented protocol that checks clean, into the current folder."""
    try:
        plain = protocol_name(name)
        path = Path(f"{plain}.yaml")
        example = check_text(template_text(template), f"{template}.yaml", lab=lab)
        if example.lab is None or example.protocol is None:
            print_problems(example.problems, file=sys.stderr)
            raise typer.Exit(PROBLEMS)
        made = new_protocol(plain, template, example.protocol, example.lab)
        _write(path, made.text)
    except CannotMake as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None
    _say_next(path, made.binds, lab)


def _write(path: Path, text: str) -> None:
    """Only where nothing stands yet: opened for a new file, so that no race overwrites one."""
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise CannotMake(f"{path} is there already; choose another name, or move it away") from None
    except OSError as fault:
        raise CannotMake(f"{path} cannot be written: {fault.strerror or fault}") from None


def _say_next(path: Path, binds: dict[str, str], lab: Path | None) -> None:
    file = f'"{path}"' if " " in str(path) else str(path)
    options = "".join(f" --bind {role}={device}" for role, device in binds.items())
    options = (f" --lab {lab}" if lab is not None else "") + options
    print(f"{path} is written. Next:")
    print(f"  labrun check {file}{options}")
    print(f"  labrun rehearse {file}{options}" if lab is not None else f"  labrun {file}{options}")
