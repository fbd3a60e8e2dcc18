"""labrun: laboratory experiments as YAML, checked, run on real devices, and never lost."""

from typing import Any

__version__ = "0.1.0"

_WHERE = {
    "check": "engine.python_api.checking:check",
    "rehearse": "engine.python_api.checking:rehearse",
    "ActionFailed": "engine.python_api.faults:ActionFailed",
    "ProtocolFault": "engine.python_api.faults:ProtocolFault",
    "Refused": "engine.python_api.faults:Refused",
    "Lab": "engine.python_api.lab:Lab",
    "lab": "engine.python_api.lab:lab",
    "Protocol": "engine.python_api.protocol:Protocol",
    "steps": "engine.python_api.protocol:",
    "RecordedRun": "engine.python_api.recorded_run:RecordedRun",
    "compare": "engine.python_api.recorded_run:compare",
    "load": "engine.python_api.recorded_run:load",
    "runs": "engine.python_api.recorded_run:runs",
    "values": "engine.python_api.recorded_run:values",
    "LiveRun": "engine.python_api.running:LiveRun",
    "arun": "engine.python_api.running:arun",
    "run": "engine.python_api.running:run",
    "start": "engine.python_api.running:start",
    "read_spectrum": "reduction.spectrum.read:read_spectrum",
}
"""Name -> its module, and its name there if it is not all of it. `__init__.pyi` tells type checkers."""
__all__ = list(_WHERE)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    """What `import labrun` offers is loaded when it is asked for: the import itself costs nothing."""
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    place, _, there = _WHERE[name].partition(":")
    module = import_module(f".{place}", __name__)
    return getattr(module, there) if there else module


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
