import numpy as np
import pytest

from labrun.reduction.lines.air import to_air
from labrun.reduction.lines.lines import line_table, lines_of, partition_function, species


def test_the_table_has_the_rows_that_its_sources_page_counts():
    table = line_table()

    assert len(table) == 30_666
    assert len(set(table.element.tolist())) == 83
    assert np.isfinite(table.stark_density_per_cm3).sum() == 2_006


def test_the_lines_ascend_within_the_range_and_are_of_stages_one_and_two():
    table = line_table()

    assert np.all(np.diff(table.wavelength_nm) >= 0)
    assert table.wavelength_nm[0] > 190 and table.wavelength_nm[-1] < 961
    assert set(table.stage.tolist()) == {1, 2}


def test_photon_energies_agree_with_vacuum_wavelengths():
    table = line_table()
    photon_ev = 1239.84198 / table.wavelength_nm

    assert np.allclose(photon_ev, table.e_k_ev - table.e_i_ev, rtol=3e-4)


@pytest.mark.parametrize(
    ("element", "air_nm", "a_ki_per_s", "g_k"),
    [
        ("Li", 670.776, 3.689e7, 4),
        ("K", 766.490, 3.779e7, 4),
        ("Na", 588.995, 6.16e7, 4),
        ("Si", 288.158, 2.17e8, 3),
        ("H", 656.282, 4.4101e7, 18),
        ("C", 193.0270, 3.67e8, 3),  # Kurucz; 193.0905 in vacuum
        ("Zr", 339.198, 1.79e8, 12),  # Ljung et al. 2006: log gf 0.57
        ("Nb", 309.418, 1.94e8, 13),  # Nilsson et al. 2010: log gf 0.56
    ],
)
def test_well_known_lines_are_where_they_belong(element, air_nm, a_ki_per_s, g_k):
    lines = lines_of(element)
    nearest = np.argmin(np.abs(to_air(lines.wavelength_nm) - air_nm))

    assert to_air(lines.wavelength_nm)[nearest] == pytest.approx(air_nm, abs=0.002)
    assert lines.a_ki_per_s[nearest] == pytest.approx(a_ki_per_s, rel=1e-3)
    assert lines.g_k[nearest] == g_k


def test_hydrogen_alpha_is_one_line_and_not_its_fine_structure():
    hydrogen = lines_of("H")
    alpha = (hydrogen.wavelength_nm > 656) & (hydrogen.wavelength_nm < 657)

    assert alpha.sum() == 1


def test_every_line_has_the_levels_of_its_species():
    table = line_table()
    pairs = set(zip(table.element.tolist(), table.stage.tolist(), strict=True))

    assert all(species(element, stage).ionisation_ev > 0 for element, stage in pairs)


def test_a_cold_atom_has_the_weight_of_its_ground_state():
    assert partition_function("Li", 1, 300.0) == pytest.approx(2.0)
    assert partition_function("H", 1, 10_000.0) == pytest.approx(2.0, rel=1e-3)


def test_the_partition_function_of_calcium_ions_is_the_sum_over_their_lowest_levels():
    # 4s, 3d (two) and 4p (two) in eV with their weights; all others lie above 6 eV.
    levels = [(0.0, 2), (1.6924, 4), (1.6999, 6), (3.1234, 2), (3.1510, 4)]
    by_hand = sum(g * np.exp(-e / (8.617333e-5 * 10_000.0)) for e, g in levels)

    assert partition_function("Ca", 2, 10_000.0) == pytest.approx(by_hand, rel=0.01)


def test_a_stark_width_grows_with_the_density_and_is_nan_where_there_is_none():
    lithium = lines_of("Li")
    red = np.argmin(np.abs(lithium.wavelength_nm - 670.961))
    one, two = (lithium.stark_fwhm_nm(10_000.0, density)[red] for density in (1e17, 2e17))

    assert two == pytest.approx(2 * one)
    assert 0.01 < one < 0.1
    assert np.isnan(lines_of("H").stark_fwhm_nm(10_000.0, 1e17)).all()


def test_an_unknown_element_is_refused_by_name():
    with pytest.raises(ValueError, match="no lines of 'Xx'"):
        lines_of("Xx")
    with pytest.raises(ValueError, match="stage 3"):
        species("Li", 3)


def test_the_table_cannot_be_written_to():
    with pytest.raises(ValueError, match="read-only"):
        line_table().wavelength_nm[0] = 0.0
