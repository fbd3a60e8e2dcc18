"""What `import labrun` offers, for type checkers and editors; `__init__.py` loads it when it is asked for."""

from .engine.python_api import protocol as steps
from .engine.python_api.checking import check, rehearse
from .engine.python_api.faults import ActionFailed, ProtocolFault, Refused
from .engine.python_api.lab import Lab, lab
from .engine.python_api.protocol import Protocol
from .engine.python_api.recorded_run import RecordedRun, compare, load, runs, values
from .engine.python_api.running import LiveRun, arun, run, start
from .reduction.spectrum.read import read_spectrum

__version__: str
__all__ = [
    "ActionFailed",
    "Lab",
    "LiveRun",
    "Protocol",
    "ProtocolFault",
    "RecordedRun",
    "Refused",
    "arun",
    "check",
    "compare",
    "lab",
    "load",
    "read_spectrum",
    "rehearse",
    "run",
    "runs",
    "start",
    "steps",
    "values",
]  # fmt: skip
