"""`labrun answer RUN ID CHOICE`: answer a question of a live run from another shell."""

from typing import Annotated

import typer

from .options import RUNS, Runs, pairs
from .resume import RunName
from .run_control import tell_run


def answer(
    run: RunName,
    id: Annotated[str, typer.Argument(help="The id of the step that asks.")],
    choice: Annotated[str, typer.Argument(help="One of the choices; yes or no for a confirm.")],
    result: Annotated[
        list[str] | None,
        typer.Option(
            "-r",
            "--result",
            metavar="NAME=VALUE",
            help="With `happened`: what the action returned.",
        ),
    ] = None,
    runs: Runs = RUNS,
) -> None:
    """Answer an open question of a run."""
    tell_run(runs, run, verb="answer", id=id, choice=choice, values=pairs(result, "-r"))
