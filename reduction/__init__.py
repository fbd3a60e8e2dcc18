"""Turn spectra into peaks, elements and maps; this package knows no device.

The names below are imported when they are first used: the fits compile themselves, the figures
draw, and neither should slow down a command that needs neither.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .fault import Unreadable
    from .figure import draw_element_maps
    from .lines import line_table, lines_of
    from .maps import ElementMap, element_map
    from .read import read_spectrum
    from .reduce import Reduction, reduce_spectrum
    from .shots import Shots, read_shots
    from .spectrum import Spectrum

__all__ = [
    "ElementMap",
    "Reduction",
    "Shots",
    "Spectrum",
    "Unreadable",
    "draw_element_maps",
    "element_map",
    "line_table",
    "lines_of",
    "read_shots",
    "read_spectrum",
    "reduce_spectrum",
]

_HOME = {
    "ElementMap": "maps",
    "Reduction": "reduce",
    "Spectrum": "spectrum",
    "Shots": "shots",
    "Unreadable": "fault",
    "draw_element_maps": "figure",
    "element_map": "maps",
    "line_table": "lines",
    "lines_of": "lines",
    "read_shots": "shots",
    "read_spectrum": "read",
    "reduce_spectrum": "reduce",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)
