"""Areas of lines that are seen, faint, full or out of range, on spectra whose areas are known."""

import numpy as np
import pytest
from scipy.special import voigt_profile

from labrun.reduction import Spectrum, reduce_spectrum
from labrun.reduction.calibration.signals import candidates, line_near, line_signal, total_light

X = np.linspace(580.0, 690.0, 1500)
LI = line_near("Li")


def reduction(rng, lithium, full=np.inf):
    y = 100 + rng.normal(0, 3, len(X))
    for area, nm in ((900, 588.995), (450, 589.592), (lithium, 670.78)):
        y += area * voigt_profile(X - nm, 0.12, 0.03)
    return reduce_spectrum(Spectrum(X, np.minimum(y, full)), ["Li"])


def test_a_peak_has_its_area_and_the_noise_of_a_spectrum_without_it():
    found = line_signal(reduction(np.random.default_rng(1), 300.0), LI)

    assert found.area == pytest.approx(300, rel=0.03)
    assert 0.3 < found.noise < 1.5


def test_where_there_is_nothing_areas_scatter_around_nothing_by_the_noise():
    rng = np.random.default_rng(2)
    told = [line_signal(reduction(rng, 0.0), LI) for _ in range(60)]
    areas, noise = np.array([t.area for t in told]), np.mean([t.noise for t in told])

    assert (areas < 0).sum() > 15
    assert areas.mean() == pytest.approx(0, abs=0.5 * noise)
    assert areas.std() == pytest.approx(noise, rel=0.4)


def test_a_full_line_and_one_out_of_range_have_no_signal():
    full = reduction(np.random.default_rng(3), 3000.0, full=2500.0)

    assert full.bad.full.any()
    assert line_signal(full, LI) is None
    assert line_signal(full, line_near("Ca")) is None


def test_lines_are_chosen_by_wavelength_in_air_or_by_strength():
    assert line_near("Li", 610.4).wavelength_nm == pytest.approx(610.53, abs=0.02)
    assert [round(one.wavelength_nm) for one in candidates("Li", (580.0, 690.0))] == [671, 611]
    with pytest.raises(ValueError, match=r"the nearest is 611\.8"):
        line_near("Li", 615.0)


def test_total_light_counts_the_continuum():
    found = total_light(reduction(np.random.default_rng(4), 300.0))

    assert found == pytest.approx(110 * 100 + 900 + 450 + 300, rel=0.01)
