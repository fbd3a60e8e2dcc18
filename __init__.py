"""labrun: laboratory experiments as YAML, checked, run on real devices, and never lost."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .engine.python_api.checking import ProtocolFault, check, rehearse
    from .engine.python_api.recorded_run import RecordedRun, load
    from .engine.python_api.recorded_run import recorded_runs as runs
    from .engine.python_api.running import LiveRun, arun, run, start

__version__ = "0.1.0"
__all__ = [
    "LiveRun", "ProtocolFault", "RecordedRun", "arun", "check", "load", "rehearse", "run", "runs",
    "start",
]  # fmt: skip

_WHERE = {
    "ProtocolFault": "checking", "check": "checking", "rehearse": "checking",
    "RecordedRun": "recorded_run", "load": "recorded_run", "runs": "recorded_run",
    "LiveRun": "running", "arun": "running", "run": "running", "start": "running",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    """What `import labrun` offers is loaded when it is asked for: the import itself costs nothing."""
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    module = import_module(f".engine.python_api.{_WHERE[name]}", __name__)
    return getattr(module, "recorded_runs" if name == "runs" else name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
