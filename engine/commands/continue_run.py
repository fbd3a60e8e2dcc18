"""`labrun continue RUN`: continue a paused run."""

from .options import RUNS, Runs
from .resume import RunName
from .run_control import tell_run


def continue_run(run: RunName, runs: Runs = RUNS) -> None:
    """Continue a paused run."""
    tell_run(runs, run, verb="continue")
