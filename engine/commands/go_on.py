"""`labrun continue RUN`: let a paused run go on."""

from .options import RUNS, Runs
from .resume import RunName
from .tell_run import tell_run


def go_on(run: RunName, runs: Runs = RUNS) -> None:
    """Let a paused run go on."""
    tell_run(runs, run, verb="continue")
