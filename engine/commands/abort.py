"""`labrun abort RUN`: cancel a run and bring its devices to their safe state."""

from .options import RUNS, Runs
from .resume import RunName
from .run_control import tell_run


def abort(run: RunName, runs: Runs = RUNS) -> None:
    """Cancel, run `finally`, bring the devices to their safe state; abort twice to stop at once."""
    tell_run(runs, run, verb="abort")
