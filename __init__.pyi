"""What `import labrun` offers, for type checkers and editors; `__init__.py` loads it when it is asked for."""

from .engine.python_api.checking import check as check
from .engine.python_api.checking import rehearse as rehearse
from .engine.python_api.faults import ActionFailed as ActionFailed
from .engine.python_api.faults import ProtocolFault as ProtocolFault
from .engine.python_api.faults import Refused as Refused
from .engine.python_api.lab import Lab as Lab
from .engine.python_api.lab import lab as lab
from .engine.python_api.recorded_run import RecordedRun as RecordedRun
from .engine.python_api.recorded_run import load as load
from .engine.python_api.recorded_run import runs as runs
from .engine.python_api.running import LiveRun as LiveRun
from .engine.python_api.running import arun as arun
from .engine.python_api.running import run as run
from .engine.python_api.running import start as start
from .reduction.spectrum.read import read_spectrum as read_spectrum

__version__: str
