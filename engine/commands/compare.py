"""`labrun compare RUN RUN...`: what differs between runs, and what each came to."""

import json as jsonlib
from dataclasses import asdict
from typing import Annotated

import typer

from .options import RUNS, Runs, fail, run_folder

Names = Annotated[
    list[str],
    typer.Argument(
        metavar="RUN RUN...", help="Names of runs, or ends of them.", show_default=False
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print it as JSON.")]


def compare(names: Names, runs: Runs = RUNS, json: Json = False) -> None:
    """Show parameters, protocol lines, outcomes, values, times and failures of runs side by side."""
    from ..index.comparison import MOST, compare_runs

    if not 2 <= len(names) <= MOST:
        fail(f"name two to {MOST} runs; `labrun runs` lists them")
    made = compare_runs([run_folder(runs, name) for name in names])
    if json:
        told = {**asdict(made), "runs": [entry.run for entry in made.runs]}
        typer.echo(jsonlib.dumps(told, indent=1))
        return
    typer.echo(str(made))
