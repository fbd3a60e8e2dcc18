"""`labrun pause RUN`: finish what runs now, then hold."""

from .options import RUNS, Runs
from .resume import RunName
from .tell_run import tell_run


def pause(run: RunName, runs: Runs = RUNS) -> None:
    """Finish what runs now, then hold."""
    tell_run(runs, run, verb="pause")
