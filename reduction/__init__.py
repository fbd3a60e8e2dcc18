"""Turn spectra into peaks, elements and maps.

Knows nothing about devices. The names below are imported on first use: the fits are compiled and
the figures load a plotting library, which should not slow down a command that needs neither. A
step named like its module has a longer name here (`estimate_background`).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .elements.doublets import self_absorbed
    from .elements.evidence import Evidence
    from .elements.evidence import evidence as weigh_evidence
    from .elements.hydrogen import h_alpha
    from .elements.identify import Identified
    from .elements.identify import identify as identify_peaks
    from .elements.offsets import Offsets, estimate_offsets
    from .elements.state import PlasmaState, mcwhirter_density, plasma_state
    from .figures.figure import draw_element_maps
    from .lines.air import to_air, to_vacuum
    from .lines.lines import line_table, lines_of
    from .maps.maps import ElementMap, element_map
    from .peaks.background import background as estimate_background
    from .peaks.background import despike
    from .peaks.peaks import find_peaks
    from .peaks.pitch import averaged, fit_at_pitch
    from .peaks.profiles import Profiles, fit_profiles, search_residual
    from .peaks.voigt import VoigtPeaks, fit_peaks
    from .peaks.voigt import voigt as voigt_profile
    from .plasma.boltzmann import Plot, PlotLines, fit_plot
    from .plasma.lithium import ratio_curve, ratio_temperature
    from .plasma.plasma import relative_strengths, saha_ratio
    from .reduce import Reduction, reduce_spectrum
    from .spectrum.bad import BadChannels, mark_bad
    from .spectrum.fault import Unreadable
    from .spectrum.noise import local_noise
    from .spectrum.read import read_shots, read_spectrum
    from .spectrum.resampled import resampled as channels_sharing_noise
    from .spectrum.shots import Shots
    from .spectrum.spectrum import Spectrum

__all__ = [
    "BadChannels",
    "ElementMap",
    "Evidence",
    "Identified",
    "Offsets",
    "PlasmaState",
    "Plot",
    "PlotLines",
    "Profiles",
    "Reduction",
    "Shots",
    "Spectrum",
    "Unreadable",
    "VoigtPeaks",
    "averaged",
    "channels_sharing_noise",
    "despike",
    "draw_element_maps",
    "element_map",
    "estimate_background",
    "estimate_offsets",
    "find_peaks",
    "fit_at_pitch",
    "fit_peaks",
    "fit_plot",
    "fit_profiles",
    "h_alpha",
    "identify_peaks",
    "line_table",
    "lines_of",
    "local_noise",
    "mark_bad",
    "mcwhirter_density",
    "plasma_state",
    "ratio_curve",
    "ratio_temperature",
    "read_shots",
    "read_spectrum",
    "reduce_spectrum",
    "relative_strengths",
    "saha_ratio",
    "search_residual",
    "self_absorbed",
    "to_air",
    "to_vacuum",
    "voigt_profile",
    "weigh_evidence",
]

_NAMES = {
    "elements.doublets": "self_absorbed",
    "elements.evidence": "Evidence weigh_evidence",
    "elements.hydrogen": "h_alpha",
    "elements.identify": "Identified identify_peaks",
    "elements.offsets": "Offsets estimate_offsets",
    "elements.state": "PlasmaState mcwhirter_density plasma_state",
    "figures.figure": "draw_element_maps",
    "lines.air": "to_air to_vacuum",
    "lines.lines": "line_table lines_of",
    "maps.maps": "ElementMap element_map",
    "peaks.background": "despike estimate_background",
    "peaks.peaks": "find_peaks",
    "peaks.pitch": "averaged fit_at_pitch",
    "peaks.profiles": "Profiles fit_profiles search_residual",
    "peaks.voigt": "VoigtPeaks fit_peaks voigt_profile",
    "plasma.boltzmann": "Plot PlotLines fit_plot",
    "plasma.lithium": "ratio_curve ratio_temperature",
    "plasma.plasma": "relative_strengths saha_ratio",
    "reduce": "Reduction reduce_spectrum",
    "spectrum.bad": "BadChannels mark_bad",
    "spectrum.fault": "Unreadable",
    "spectrum.noise": "local_noise",
    "spectrum.read": "read_shots read_spectrum",
    "spectrum.resampled": "channels_sharing_noise",
    "spectrum.shots": "Shots",
    "spectrum.spectrum": "Spectrum",
}
_OWN_NAME = {
    "channels_sharing_noise": "resampled",
    "estimate_background": "background",
    "identify_peaks": "identify",
    "voigt_profile": "voigt",
    "weigh_evidence": "evidence",
}
_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), _OWN_NAME.get(name, name))
