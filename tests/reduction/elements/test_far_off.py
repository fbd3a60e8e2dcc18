"""Spectra on axes that are nanometres off, each detector by as much as it likes."""

import numpy as np
import pytest

from labrun.reduction import Spectrum, reduce_spectrum

pytestmark = pytest.mark.slow

GAPS_NM = ((340.0, 382.0), (474.0, 492.0))


def on_wrong_axis(truth, off_nm):
    """Three detectors of a spectrum, each shown so far from where it should be."""
    x, y = truth.wavelength_nm, truth.intensity
    kept = np.ones(len(x), dtype=bool)
    for low, high in GAPS_NM:
        kept &= (x < low) | (x > high)
    which = np.searchsorted([low for low, _ in GAPS_NM], x[kept])
    return Spectrum(x[kept] + np.array(off_nm)[which], y[kept])


def test_lines_are_found_on_an_axis_that_is_nanometres_off(reduced):
    truth, right = reduced("train", 4)
    found = reduce_spectrum(on_wrong_axis(truth, (-0.62, -0.58, -2.6)))
    well_known = {e for e in right.detected if right.evidence[e].score > 15}
    (note,) = [one for one in found.notes if "far off" in one]

    assert len(well_known) >= 4
    assert len(well_known - set(found.detected)) <= 1
    assert set(found.detected) <= {*truth.present, *right.detected}
    told = [float(part.split()[0]) for part in note.split("were moved ")[1].split(", ")[:3]]
    assert told == pytest.approx([0.62, 0.58, 2.6], abs=0.15)


def test_a_right_axis_and_noise_are_left_alone(reduced):
    truth, _ = reduced("train", 0)
    rng = np.random.default_rng(3)
    noise = Spectrum(truth.wavelength_nm, 300 + 5 * rng.normal(size=len(truth.wavelength_nm)))

    for spectrum in (on_wrong_axis(truth, (0.0, 0.05, -0.05)), noise):
        assert not any("far off" in note for note in reduce_spectrum(spectrum).notes)
