import numpy as np
import pytest

from labrun.reduction.lines.air import in_medium, to_air, to_vacuum


def test_the_sodium_line_has_the_air_wavelength_of_the_textbooks():
    assert to_air(np.array(589.15832)) == pytest.approx(588.9950, abs=2e-4)


def test_there_and_back_is_the_same_wavelength():
    vacuum_nm = np.linspace(150, 961, 5000)

    assert np.allclose(to_vacuum(to_air(vacuum_nm)), vacuum_nm, rtol=0, atol=1e-9)


def test_below_200_nm_the_scale_goes_on():
    vacuum_nm = np.linspace(185, 215, 3001)
    steps = np.diff(to_air(vacuum_nm))

    assert np.ptp(steps) < 2e-6
    # Birch and Downs (Metrologia 31, 315 (1994)), another formula of the same air: 193.0268.
    assert to_air(np.array(193.0905)) == pytest.approx(193.0268, abs=2e-4)


def test_water_is_no_medium():
    with pytest.raises(ValueError, match="'water'"):
        in_medium(np.array([500.0]), "water")  # pyright: ignore[reportArgumentType]
