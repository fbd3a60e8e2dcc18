"""`labrun pause RUN`: finish what is running, then hold."""

from .options import RUNS, Runs
from .resume import RunName
from .run_control import tell_run


def pause(run: RunName, runs: Runs = RUNS) -> None:
    """Finish what is running, then hold."""
    tell_run(runs, run, verb="pause")
