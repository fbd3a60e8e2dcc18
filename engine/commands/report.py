"""`labrun report RUN`: make a run's report and figures, or make them again."""

import typer

from ..exit_status import FAILED
from .options import RUNS, Runs, run_folder, say
from .resume import RunName


def report(run: RunName, runs: Runs = RUNS) -> None:
    """(Re)make the report and the figures of a run."""
    from ..runner.reports import make_reports

    folder = run_folder(runs, run)
    made, failed = make_reports(folder)
    for path in made:
        typer.echo(f"made {path}")
    for line in failed:
        say(line)
    if not made and not failed:
        typer.echo(f"{folder.name} has nothing to draw: no rows with x, y and an element")
    raise typer.Exit(FAILED if failed else 0)
