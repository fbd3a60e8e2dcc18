import numpy as np
import pytest

from labrun.reduction.elements.gain_steps import gain_steps

X = np.linspace(200.0, 900.0, 7_000)


def continuum(*steps: tuple[float, float]) -> np.ndarray:
    """Light between lines under detectors that begin at a wavelength and have a gain; with lines."""
    gain = np.ones(len(X))
    for begins_nm, of in steps:
        gain[begins_nm <= X] = of
    rng = np.random.default_rng(3)
    lines = sum(
        500 / (1 + ((X - at) / 0.1) ** 2) for at in rng.uniform(210, 890, 60)
    )  # their feet rise and fall
    return gain * (100.0 + lines) + rng.normal(0, 4, len(X))


@pytest.mark.parametrize("steps", [((350.0, 4.0),), ((350.0, 4.0), (620.0, 1.6)), ((500.0, 0.1),)])
def test_where_the_continuum_jumps_and_stays_a_detector_begins(steps):
    found = gain_steps(X, continuum(*steps))

    for begins_nm, _ in steps:
        assert np.abs(found - begins_nm).min() < 1.0


def test_a_level_continuum_with_lines_has_no_step():
    assert not len(gain_steps(X, continuum()))


def test_a_short_spectrum_has_none():
    assert not len(gain_steps(X[:100], continuum()[:100]))
