"""`labrun abort RUN`: cancel, run `finally`, put the devices into their safe state; twice: at once."""

from .options import RUNS, Runs
from .resume import RunName
from .tell_run import tell_run


def abort(run: RunName, runs: Runs = RUNS) -> None:
    """Cancel, run `finally`, put the devices into their safe state; twice: at once."""
    tell_run(runs, run, verb="abort")
