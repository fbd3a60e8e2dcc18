import numpy as np
import pytest
from scipy.special import wofz

from labrun.reduction.peaks.faddeeva import faddeeva


@pytest.mark.parametrize("size", [0.0, 0.3, 2.0, 7.9, 8.1, 60.0, 1e4])
def test_it_agrees_with_scipy_in_the_upper_half_plane(size):
    points = size * np.exp(1j * np.linspace(0, np.pi, 41))
    points = points.real + 1j * np.abs(points.imag)
    found = np.array([faddeeva(complex(z)) for z in points])

    assert np.allclose(found, wofz(points), rtol=1e-8)
