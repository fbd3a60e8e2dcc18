"""The spectrometer: 22,800 channels, air wavelengths, a slit that blurs, a detector with noise."""

import numpy as np

CHANNELS = 22_800
FIRST_NM, LAST_NM = 190.0, 950.0
CHANNEL_NM = (LAST_NM - FIRST_NM) / (CHANNELS - 1)
SLIT_NM = 0.1  # full width at half maximum
FULL_WELL = 65_535.0
READ_NOISE = 4.0
COUNTS_PER_ELECTRON = 0.3  # what one more electron adds
# Three detectors, each with its own small error of wavelength.
SEGMENTS_NM = (365.0, 620.0)
OFFSETS_NM = (0.006, -0.009, 0.011)


def axis() -> np.ndarray:
    """Wavelength in air of every channel, nm."""
    return np.linspace(FIRST_NM, LAST_NM, CHANNELS)


def shown_at(vacuum_nm: np.ndarray) -> np.ndarray:
    """Where on the axis a line appears: in air, with its detector's error."""
    squared = (1000.0 / vacuum_nm) ** 2
    index = 1.0 + 0.05792105 / (238.0185 - squared) + 0.00167917 / (57.362 - squared)  # Ciddor
    air = vacuum_nm / index
    return air + np.asarray(OFFSETS_NM)[np.searchsorted(SEGMENTS_NM, air)]


def detect(light: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Counts that the detector reports for so much light: photon noise, read noise, full well."""
    noise = np.sqrt(COUNTS_PER_ELECTRON * light + READ_NOISE**2)
    counts = light + noise * random.standard_normal(len(light), dtype=np.float32)
    return np.clip(counts, 0.0, FULL_WELL)


def blur(fine: np.ndarray, channels: np.ndarray) -> np.ndarray:
    """What the slit makes of light at places `fine`: shape (fine, channels), both in channels.

    The fine places are evenly spaced; the light at each stands for its whole interval.
    """
    sigma = SLIT_NM / 2.354820045 / CHANNEL_NM
    away = (fine[:, None] - channels) / sigma
    return np.exp(-(away**2) / 2) / (sigma * np.sqrt(2 * np.pi)) * (fine[1] - fine[0])
