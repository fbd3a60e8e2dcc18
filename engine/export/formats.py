"""The formats of `labrun export`: a table of our own, and what plug-ins register as `labrun.exports`.

A format is a function of a run's folder and the file to write; it returns nothing and raises
ExportFault with a sentence.
"""

from collections.abc import Callable
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path

from ...system.extras import not_installed

Export = Callable[[Path, Path], None]
OWN = {"mcap": "mcap:write", "nexus": "nexus:write", "tiff": "tiff:write"}
"""Format, which is also the file's suffix -> module in this folder and function."""
SUFFIXES = {"nexus": "nxs", "tiff": "tif"}
"""Where it is another one."""


class ExportFault(Exception):
    """A run cannot be exported; the text says why and what to do."""


def formats() -> dict[str, Callable[[], Export]]:
    """Every format by name; each is loaded when it is called."""

    def own(place: str) -> Callable[[], Export]:
        module, _, name = place.partition(":")

        def load() -> Export:
            try:
                return getattr(import_module(f".{module}", __package__), name)
            except ImportError as fault:
                raise ExportFault(not_installed(fault, "export") or str(fault)) from fault

        return load

    found = {name: own(place) for name, place in OWN.items()}
    return found | {point.name: point.load for point in entry_points(group="labrun.exports")}
