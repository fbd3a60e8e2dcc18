"""The response of a made-up instrument, from its lamp and from what lines told."""

from dataclasses import replace

import numpy as np
import pytest

from labrun.drivers.simulated.twins.shot import ShotMaker
from labrun.reduction import read_spectrum, reduce_spectrum
from labrun.reduction.elements.calibrate_response import from_lamp, from_lines
from labrun.reduction.plasma.boltzmann import CALIBRATION, Bend, fit_plot
from labrun.reduction.plasma.response import LOOSE, stiffness
from labrun.reduction.spectrum.spectrum import Spectrum

SEAM_NM = 470.0


def axis():
    """Two detectors of unlike pitch, which meet at 470 nm."""
    return np.concatenate([np.arange(200.0, SEAM_NM, 0.05), np.arange(SEAM_NM, 900.0, 0.09)])


def true_response(nm):
    roll_off = 0.3 + 0.7 * np.exp(-(((nm - 550) / 200) ** 2))
    return roll_off * np.where(nm < SEAM_NM, 1.0, 3.9)


def radiance_of_a_filament(nm):
    return 1e-3 * nm**-5 / (np.exp(1.4388e7 / (nm * 3000)) - 1) * 1e14


def lamp_nm_and_radiance():
    """As certificates have them: 50 nm and more from one to the next, where a straight line is 8 % off."""
    nm = np.array(
        [250.0, 260, 270, 280, 290, 300, 320, 350, 400, 450, 500, 555, 600, 700, 800, 900, 1050]
    )
    return nm, radiance_of_a_filament(nm)


def test_a_lamp_tells_roll_off_and_the_step_between_detectors():
    rng = np.random.default_rng(4)
    x, (certified_nm, radiance) = axis(), lamp_nm_and_radiance()
    light = radiance_of_a_filament(x)
    counts = 4e3 * true_response(x) * light / light.max()
    lamp = Spectrum(x, rng.normal(counts, np.sqrt(counts + 4)))
    found = from_lamp(lamp, certified_nm, radiance)
    true = true_response(found.wavelength_nm)
    z = np.log(found.response / true)
    z -= np.average(z, weights=1 / found.error**2)
    just_before, just_after = (
        found.response[np.argmin(np.abs(found.wavelength_nm - at))] for at in (468.5, 471.5)
    )

    assert found.wavelength_nm[0] > 250  # where the certificate begins
    assert just_after / just_before == pytest.approx(3.9, rel=0.03)
    assert 0.5 < np.mean(np.abs(z) < found.error) < 0.85
    assert np.mean(np.abs(z) < 3 * found.error) > 0.98


def test_a_lamp_that_was_off_tells_nothing():
    x, (certified_nm, radiance) = axis(), lamp_nm_and_radiance()
    with pytest.raises(ValueError, match="nowhere above the dark"):
        from_lamp(Spectrum(x, np.full(len(x), -1.0)), certified_nm, radiance)


@pytest.fixture(scope="module")
def core():
    """The elements and lines of a shot at the simulated core."""
    shot = ShotMaker(core=1, seed=3).csv({"n": 1, "x": 1.2, "y": 3.0, "focus": 1.0})
    return reduce_spectrum(read_spectrum(shot)).identified


KNOTS = np.linspace(240.0, 880.0, 17)


def bent(core, gain, seed):
    """The core's lines through a response, which is ln(gain) at KNOTS, as one spectrum tells it."""
    lines, rng = core.lines, np.random.default_rng(seed)
    off = np.interp(lines.vacuum_nm, KNOTS, gain) - core.plot.residual
    off += rng.normal(0, np.hypot(lines.error, CALIBRATION))
    bend = Bend(KNOTS, 0 * KNOTS, stiffness(KNOTS, np.empty(0), LOOSE))
    shown = replace(lines, log_area=lines.log_area + off)
    plot = fit_plot(shown, bend=bend)
    own = replace(shown, log_area=shown.log_area - plot.response.at(shown.vacuum_nm))
    return replace(core, lines=own, plot=plot, bend=bend, response=plot.response)


def test_the_lines_of_all_spectra_tell_one_response_better_than_those_of_one(core):
    true = 1.5 * np.sin(KNOTS / 90)
    found = [bent(core, true, seed) for seed in range(8)]
    told = from_lines(KNOTS, found)
    spoiled = from_lines(KNOTS, [*found, bent(core, -3 * true, 9)])

    def off(response):
        error = np.log(response) - true
        return error - np.average(error, weights=told.response.error**-2)

    apart = [off(np.exp(one.response.at(KNOTS))) for one in found]
    assert told.response.wavelength_nm == pytest.approx(KNOTS)
    assert np.mean(np.abs(off(told.response.response)) < 2 * told.response.error) > 0.8
    assert np.std(off(told.response.response)) < 0.7 * np.median(np.std(apart, axis=1))
    assert told.spectra == 8
    assert off(spoiled.response.response) == pytest.approx(off(told.response.response), abs=0.3)


def test_one_spectrum_tells_a_response_with_a_large_error(core):
    few = from_lines(KNOTS, [core, None])
    many = from_lines(KNOTS, [core] * 8)

    assert few.spectra == 1
    assert np.median(few.response.error) > 2 * np.median(many.response.error)
    with pytest.raises(ValueError, match="no spectrum has enough lines to tell a response"):
        from_lines(KNOTS, [None] * 6)
