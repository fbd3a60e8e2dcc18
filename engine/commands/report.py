"""`labrun report RUN`: make a run's report and figures, or make them again."""

import typer

from ..exit_status import FAILED, PROBLEMS
from .options import RUNS, Runs, say
from .resume import RunName


def report(run: RunName, runs: Runs = RUNS) -> None:
    """(Re)make the report and the figures of a run."""
    from ..run.folder import FolderFault, find_run
    from ..runner.reports import make_reports

    try:
        folder = find_run(runs, run)
    except FolderFault as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None
    made, failed = make_reports(folder)
    for path in made:
        typer.echo(f"made {path}")
    for line in failed:
        say(line)
    if not made and not failed:
        typer.echo(f"{folder.name} has nothing to draw: no rows with x, y and an element")
    raise typer.Exit(FAILED if failed else 0)
