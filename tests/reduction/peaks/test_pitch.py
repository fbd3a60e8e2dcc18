import numpy as np
import pytest

from labrun.reduction import Spectrum, reduce_spectrum
from labrun.reduction.peaks.pitch import averaged, finer_than_any, fit_at_pitch
from labrun.reduction.spectrum.bad import mark_bad


def test_bad_channels_have_no_part_in_a_mean_and_a_full_one_spoils_it():
    counts = np.random.default_rng(1).normal(100, 3, 4_000)
    counts[10] = np.nan
    counts[3_000:3_003] = 65_535.0
    spectrum = Spectrum(np.linspace(200, 300, 4_000), counts)
    seen = averaged(spectrum, mark_bad(counts), 4)

    assert len(seen.spectrum) == 1_000 and seen.channels == 4
    assert seen.spectrum.intensity[2] == pytest.approx(np.mean(counts[[8, 9, 11]]))
    assert np.flatnonzero(seen.bad).tolist() == [750]
    assert seen.spectrum.wavelength_nm[0] == pytest.approx(np.mean(spectrum.wavelength_nm[:4]))


def test_one_channel_stays_what_it_is():
    spectrum = Spectrum(np.linspace(200, 300, 50), np.ones(50))

    assert averaged(spectrum, mark_bad(spectrum.intensity), 1).spectrum is spectrum


def test_an_axis_finer_than_any_spectrograph_is_averaged_at_once():
    assert finer_than_any(np.linspace(190, 961, 22_800)) == 1
    assert finer_than_any(np.linspace(580, 600, 1_000_000)) > 100
    assert finer_than_any(np.linspace(580, 580.001, 50)) == 1


@pytest.mark.parametrize("n", [900, 4_000, 30_000, 300_000])
def test_a_line_has_its_area_however_many_channels_it_covers(n):
    x = np.linspace(640, 700, n)
    rng = np.random.default_rng(3)
    counts = 100 + rng.normal(0, 3, n)
    for centre in np.arange(645, 696, 6.0):
        counts += 600 * np.exp(-0.5 * ((x - centre) / 0.1) ** 2)
    spectrum = Spectrum(x, counts)
    profiles, channels = fit_at_pitch(spectrum, mark_bad(counts))

    assert (channels > 1) == (n >= 4_000)
    assert len(profiles.peaks) == 9
    assert profiles.peaks.area == pytest.approx(600 * 0.1 * 2.5066, rel=0.05)
    assert len(profiles.wavelength_nm) == len(profiles.net) == len(profiles.bad)


def test_it_is_said_that_channels_were_averaged():
    x = np.linspace(580, 600, 20_000)
    counts = np.random.default_rng(1).normal(100, 3, len(x))
    fine, usual = (reduce_spectrum(Spectrum(x[::n], counts[::n])) for n in (1, 20))

    assert fine.averaged > 1 and "averaged" in fine.notes[0]
    assert usual.averaged == 1 and usual.notes[0].startswith("no peak stands out")
    assert len(fine.bad.any) == len(x)
