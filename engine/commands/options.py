"""Options that several commands share."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn, TextIO

import typer

from ..exit_status import PROBLEMS

if TYPE_CHECKING:
    from ...schemas.lab import LabDevice
    from ..lab.lab import LoadedLab

File = Annotated[Path, typer.Argument(help="The protocol.", show_default=False)]
Lab = Annotated[
    Path | None, typer.Option("--lab", help="The lab file; without it the simulated lab is used.")
]
Bind = Annotated[
    list[str] | None,
    typer.Option("--bind", metavar="ROLE=DEVICE", help="The device for a role."),
]
Params = Annotated[
    list[str] | None,
    typer.Option("-p", "--param", metavar="NAME=VALUE", help='A parameter: -p pitch="100 um".'),
]
Runs = Annotated[Path, typer.Option("--runs", help="The folder that run folders are kept in.")]
RUNS = Path("runs")


def by_command(command: str) -> str:
    """Who acts on a run or a device, and how: `ada (labrun stop on bench-pc)`."""
    import socket

    from ...system.process import user_name

    return f"{user_name()} (labrun {command} on {socket.gethostname()})"


class WrongUsage(ValueError):
    """Options that cannot be understood; the text states which, and how to write them."""


def pairs(texts: list[str] | None, option: str) -> dict[str, str]:
    """`["a=1", "b=2"]` as a dictionary; ends the command if a `=` is missing."""
    found: dict[str, str] = {}
    for text in texts or []:
        name, mark, value = text.partition("=")
        if not mark or not name:
            fail(f"{option} {text}: write {option} NAME=VALUE".strip())
        found[name.strip()] = value
    return found


def say(text: str) -> None:
    """Print one line for a person on stderr; stdout is for programs."""
    typer.echo(f"labrun: {text}", err=True)


def fail(text: str, status: int = PROBLEMS) -> NoReturn:
    """Print one line for a person, and end the command with this status."""
    say(text)
    raise typer.Exit(status) from None


@contextmanager
def failing_on(*faults: type[Exception], status: int = PROBLEMS) -> Iterator[None]:
    """In the block, any of these ends the command with what it says."""
    try:
        yield
    except faults as fault:
        fail(str(fault), status)


def run_folder(runs: Path, name: str) -> Path:
    """The folder of a run; ends the command where no run, or more than one, is called so."""
    from ..run.folder import FolderFault, find_run

    with failing_on(FolderFault):
        return find_run(runs, name)


def known_device(lab: "LoadedLab", name: str) -> "LabDevice":
    """A device of the lab; raises WrongUsage with what there is instead."""
    from ..language.suggest import did_you_mean

    known = lab.lab.devices
    if name not in known:
        there = f"it has {', '.join(known)}"
        raise WrongUsage(f"no device {name!r} in this lab{did_you_mean(name, known)}; {there}")
    return known[name]


def usable_lab(lab: Path | None, shown_in: TextIO | None = None) -> "LoadedLab":
    """The lab, its problems printed; ends the command where it has errors."""
    from ..lab.lab import load_lab
    from ..problems.print import print_problems

    loaded, problems = load_lab(lab)
    if problems:
        print_problems(problems, format="text", file=shown_in)
    if loaded is None or any(problem.severity == "error" for problem in problems):
        raise typer.Exit(PROBLEMS)
    return loaded
