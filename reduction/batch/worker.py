"""A process that reduces the chunks it is sent until its pipe closes."""

import signal
import warnings
from importlib import import_module
from multiprocessing.connection import Connection

from ...system.start import collector_at_rest, without
from .settings import Settings
from .work import reduce_file

UP, COMPILING, DONE = "up", "compiling", "done"


def main(link: Connection, settings: Settings) -> None:
    """Answer (number, chunk) with (DONE, number, results); ends when the other side is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is handled by the parent
    warnings.simplefilter("ignore")  # people see only what is in a row
    try:
        _tell_of_compiling(link)
        link.send((UP,))
        while True:
            number, chunk = link.recv()
            done = [reduce_file(name, path, settings) for name, path in chunk]
            link.send((DONE, number, done))
    except (EOFError, OSError):
        return


def _tell_of_compiling(link: Connection) -> None:
    """Report once that a kernel was not in the cache."""
    # numba asks scipy for a BLAS, and no loop of ours has a use for it.
    with collector_at_rest(), without("scipy.linalg"):
        from .. import reduce  # noqa: F401  # what every chunk needs; it says where numba's cache is

        import_module("numba.np.arraymath")
    events = import_module("numba.core.event")
    told = []

    class Compiling(events.Listener):
        def on_start(self, event) -> None:
            if not told:
                told.append(event)
                link.send((COMPILING,))

        def on_end(self, event) -> None: ...

    events.register("numba:compile", Compiling())
