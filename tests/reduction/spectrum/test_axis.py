import numpy as np
import pytest

from labrun.reduction import Unreadable, read_spectrum
from labrun.reduction.spectrum.axis import in_nm


def test_angstrom_and_micrometres_become_nanometres():
    assert in_nm(np.array([2_000.0, 9_000.0]), "angstrom").tolist() == [200, 900]
    assert in_nm(np.array([0.2, 0.9]), "um") == pytest.approx([200, 900])
    assert read_spectrum(b"2000,1\n9000,2\n", unit="angstrom").wavelength_nm.tolist() == [200, 900]


def test_a_wrong_unit_is_named():
    with pytest.raises(Unreadable, match="unit='angstrom'"):
        in_nm(np.array([2_000.0, 9_610.0]))
    with pytest.raises(Unreadable, match="if they are in angstrom or cm-1, say so"):
        in_nm(np.array([15_815.0, 15_820.4]))
    with pytest.raises(Unreadable, match="unit='um'"):
        in_nm(np.array([0.2, 0.96]))
    with pytest.raises(Unreadable, match="not a unit"):
        in_nm(np.array([200.0]), "pixel")  # type: ignore[arg-type]


def test_a_column_that_counts_channels_is_no_axis():
    with pytest.raises(Unreadable, match="channel numbers"):
        in_nm(np.arange(2_048.0))


def test_whole_nanometres_beyond_silicon_are_wavelengths_where_that_is_said():
    whole = np.arange(350.0, 1_400.0)
    with pytest.raises(Unreadable, match=r"channel numbers .* if they are in nm, use --unit nm"):
        in_nm(whole)

    assert in_nm(whole, "nm", said=True).tolist() == whole.tolist()


def test_zeros_are_no_spectrum_and_negative_counts_are():
    with pytest.raises(Unreadable, match="every intensity is 0"):
        read_spectrum(b"200,0\n201,0\n")

    assert read_spectrum(b"200,-3\n201,2\n").intensity.tolist() == [-3, 2]
