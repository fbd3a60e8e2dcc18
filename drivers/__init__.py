"""The device server and its client, the drivers, and the simulated twins.

Never imports `engine` or `web`: a device server runs on a machine that has neither a protocol nor
a page.
"""

import sys
from importlib import import_module
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from types import ModuleType
from warnings import warn

_MOVED = {
    f"{__name__}.{old}": f"{__name__}.{new}"
    for old, new in {
        "serial_line": "serial_io.line",
        "serial_port": "serial_io.port",
        "twins": "simulated.twins",
        "twins.twin": "simulated.twins.twin",
    }.items()
}
"""Modules that `labrun new device` of labrun 0.1 imported in drivers and twins -> their new names."""


class _Moved(Loader):
    """Find a module by its labrun 0.1 name, and warn with the new one."""

    def find_spec(self, name: str, *_: object) -> ModuleSpec | None:
        is_package = any(other.startswith(f"{name}.") for other in _MOVED)
        return ModuleSpec(name, self, is_package=is_package) if name in _MOVED else None

    def create_module(self, spec: ModuleSpec) -> None:
        """Use Python's default module type."""

    def exec_module(self, module: ModuleType) -> None:
        new = _MOVED[module.__name__]
        warn(f"{module.__name__} is now {new}", FutureWarning, stacklevel=2)
        names = vars(import_module(new))
        vars(module).update({name: names[name] for name in names if not name.startswith("__")})


sys.meta_path.append(_Moved())
