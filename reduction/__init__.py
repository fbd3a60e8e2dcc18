"""Turn spectra into peaks, elements and maps; this package knows no device.

The names below are imported when they are first used: the fits compile themselves, the figures
draw, and neither should slow down a command that needs neither. A step that is named like its
module has a longer name here (`estimate_background`), as a package has one thing of each name.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .air import to_air, to_vacuum
    from .background import background as estimate_background
    from .background import despike
    from .bad import BadChannels, mark_bad
    from .boltzmann import Plot, PlotLines, fit_plot
    from .boltzmann_plot import boltzmann_fit, boltzmann_points, boltzmann_y, saha_boltzmann_points
    from .doublets import self_absorbed
    from .evidence import Evidence
    from .evidence import evidence as weigh_evidence
    from .fault import Unreadable
    from .figure import draw_element_maps
    from .hydrogen import h_alpha
    from .identify import Identified
    from .identify import identify as identify_peaks
    from .lines import line_table, lines_of
    from .lithium import lithium_fraction, lithium_fraction_curve, ratio_curve, ratio_temperature
    from .maps import ElementMap, element_map
    from .noise import local_noise
    from .offsets import Offsets, estimate_offsets
    from .peaks import find_peaks
    from .pitch import averaged, fit_at_pitch
    from .plasma import relative_strengths, saha_ratio
    from .profiles import Profiles, fit_profiles, search_residual
    from .read import read_spectrum
    from .reduce import Reduction, reduce_spectrum
    from .resampled import resampled as channels_sharing_noise
    from .shots import Shots, read_shots
    from .spectrum import Spectrum
    from .state import PlasmaState, mcwhirter_density, plasma_state
    from .voigt import VoigtPeaks, fit_peaks
    from .voigt import voigt as voigt_profile

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
    "boltzmann_fit",
    "boltzmann_points",
    "boltzmann_y",
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
    "lithium_fraction",
    "lithium_fraction_curve",
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
    "saha_boltzmann_points",
    "saha_ratio",
    "search_residual",
    "self_absorbed",
    "to_air",
    "to_vacuum",
    "voigt_profile",
    "weigh_evidence",
]

_HOME = {
    "BadChannels": "bad",
    "ElementMap": "maps",
    "Evidence": "evidence",
    "Identified": "identify",
    "Offsets": "offsets",
    "PlasmaState": "state",
    "Plot": "boltzmann",
    "PlotLines": "boltzmann",
    "Profiles": "profiles",
    "Reduction": "reduce",
    "Shots": "shots",
    "Spectrum": "spectrum",
    "Unreadable": "fault",
    "VoigtPeaks": "voigt",
    "averaged": "pitch",
    "boltzmann_fit": "boltzmann_plot",
    "boltzmann_points": "boltzmann_plot",
    "boltzmann_y": "boltzmann_plot",
    "channels_sharing_noise": "resampled.resampled",
    "despike": "background",
    "draw_element_maps": "figure",
    "element_map": "maps",
    "estimate_background": "background.background",
    "estimate_offsets": "offsets",
    "find_peaks": "peaks",
    "fit_at_pitch": "pitch",
    "fit_peaks": "voigt",
    "fit_plot": "boltzmann",
    "fit_profiles": "profiles",
    "h_alpha": "hydrogen",
    "identify_peaks": "identify.identify",
    "line_table": "lines",
    "lines_of": "lines",
    "lithium_fraction": "lithium",
    "lithium_fraction_curve": "lithium",
    "local_noise": "noise",
    "mark_bad": "bad",
    "mcwhirter_density": "state",
    "plasma_state": "state",
    "ratio_curve": "lithium",
    "ratio_temperature": "lithium",
    "read_shots": "shots",
    "read_spectrum": "read",
    "reduce_spectrum": "reduce",
    "relative_strengths": "plasma",
    "saha_boltzmann_points": "boltzmann_plot",
    "saha_ratio": "plasma",
    "search_residual": "profiles",
    "self_absorbed": "doublets",
    "to_air": "air",
    "to_vacuum": "air",
    "voigt_profile": "voigt.voigt",
    "weigh_evidence": "evidence.evidence",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, own_name = _HOME[name].partition(".")
    return getattr(import_module(f".{module}", __name__), own_name or name)
