"""The response of a made-up instrument, from its lamp and from what lines told."""

import numpy as np
import pytest

from labrun.reduction.elements.calibrate_response import from_lamp, from_lines
from labrun.reduction.plasma.response import Response
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


def test_what_the_lines_of_several_spectra_tell_is_weighted_and_its_scatter_counts():
    knots = np.array([200.0, 400.0, 600.0])
    told = [
        Response(knots, np.array([0.0, 1.0, 2.0]) + shift, np.array([0.1, 0.1, 0.1]))
        for shift in (0, 5)
    ]  # their scales differ by e^5: nobody's concern
    apart = [told[0], Response(knots, np.array([0.0, 2.0, 1.0]), np.array([0.1, 0.1, 0.1]))]
    alike, unlike = from_lines(told), from_lines(apart)

    assert np.log(alike.response) == pytest.approx([-2, -1, 0])
    assert alike.error == pytest.approx(np.full(3, 0.1 / np.sqrt(2)))
    assert unlike.error[1] == pytest.approx(0.5)


def test_without_any_that_tells_there_is_no_response():
    with pytest.raises(ValueError, match="no spectrum has lines that tell a response"):
        from_lines([])
