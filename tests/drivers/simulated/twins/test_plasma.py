"""The plasma obeys Boltzmann, Saha and its own optical depth."""

import numpy as np
import pytest

from labrun.drivers.simulated.twins import instrument
from labrun.drivers.simulated.twins.minerals import ELEMENTS, atom_fractions
from labrun.drivers.simulated.twins.plasma import Plasma, State, spark


@pytest.fixture(scope="module")
def plasma() -> Plasma:
    return Plasma()


def atoms(**shares: float) -> np.ndarray:
    return np.array([shares.get(element, 0.0) for element in ELEMENTS])


def mineral(name: str) -> np.ndarray:
    return atoms(**atom_fractions(name))


def area(plasma: Plasma, light: np.ndarray, state: State, line_nm: float, reach_nm: float) -> float:
    near = abs(plasma.axis - line_nm) < reach_nm
    return float((light - plasma._continuum(state))[near].sum() * instrument.CHANNEL_NM)


def test_lines_from_one_upper_level_keep_their_ratio_whatever_the_temperature(plasma):
    silicon = atoms(O=0.9999, Si=0.0001)
    lines = (288.158, 390.552)  # Si I, both from 5.082 eV
    ratios = []
    for state in (State(0.9), State(1.1)):
        light = plasma.light(silicon, state)
        ratios.append(np.divide(*(area(plasma, light, state, nm, 0.25) for nm in lines)))

    assert ratios[0] == pytest.approx(ratios[1], rel=0.02)


def test_a_hotter_plasma_prefers_higher_levels_after_boltzmann(plasma):
    lithium = atoms(Li=1e-5, O=1 - 1e-5)
    ratio = []
    for kt in (0.9, 1.1):
        state = State(kt, amount=1.0)
        light = plasma.light(lithium, state)
        upper = area(plasma, light, state, 610.36, 3.0)  # from 3.879 eV
        lower = area(plasma, light, state, 670.78, 3.0)  # from 1.848 eV
        ratio.append(upper / lower)

    assert ratio[1] / ratio[0] == pytest.approx(np.exp(2.031 * (1 / 0.9 - 1 / 1.1)), rel=0.05)


def test_more_electrons_make_more_neutral_atoms_after_saha(plasma):
    silicon = plasma.species.index(next(s for s in plasma.species if s.element == "Si"))
    thin, dense = (plasma.densities(mineral("quartz"), State(1.0, n)) for n in (1e17, 2e17))
    ratio_thin = thin[silicon + 1] / thin[silicon]
    ratio_dense = dense[silicon + 1] / dense[silicon]

    assert ratio_thin / ratio_dense == pytest.approx(2)
    assert ratio_thin > 1


def test_a_resonance_line_absorbs_its_own_light(plasma):
    state = State()
    little, much = (
        area(plasma, plasma.light(atoms(Li=share, O=1 - share), state), state, 670.78, 2.0)
        for share in (1e-4, 1e-1)
    )

    assert 200 < much / little < 900


def test_hydrogen_is_as_wide_as_the_electrons_make_it(plasma):
    state = State(1.1, 1e17)
    light = plasma.light(atoms(H=1.0), state) - plasma._continuum(state)
    near = abs(plasma.axis - 656.28) < 4
    above = plasma.axis[near][light[near] > light[near].max() / 2]

    assert above[-1] - above[0] == pytest.approx(1.1, abs=0.1)


def test_lines_stand_in_air_with_their_detectors_error(plasma):
    state = State()
    light = plasma.light(mineral("spodumene"), state)
    near = abs(plasma.axis - 670.78) < 0.3
    net = (light - plasma._continuum(state))[near]

    assert np.average(plasma.axis[near], weights=net) == pytest.approx(670.785 + 0.011, abs=0.01)


def test_minerals_differ_where_a_spectroscopist_looks(plasma):
    state = State()

    def peak(name: str, line_nm: float) -> float:
        light = plasma.light(mineral(name), state) - plasma._continuum(state)
        return float(light[abs(plasma.axis - line_nm) < 0.08].max())

    assert peak("spodumene", 670.78) > 5000 > 5 > peak("quartz", 670.78)
    assert peak("K-feldspar", 766.49) > 1500 > 100 > peak("albite", 766.49)
    assert peak("albite", 588.99) > 5000
    assert peak("lepidolite", 780.03) > 50 > peak("spodumene", 780.03)
    assert peak("muscovite", 656.28) > 2 * peak("quartz", 656.28)


def test_no_two_sparks_are_alike_and_all_are_hot():
    random = np.random.default_rng(1)
    sparks = [spark(random) for _ in range(300)]

    assert all(0.9 <= s.temperature_ev <= 1.1 for s in sparks)
    assert all(0.6e17 < s.electrons_per_cm3 < 1.6e17 for s in sparks)
    assert len({s.temperature_ev for s in sparks}) > 250


def test_noise_grows_with_the_light_and_counts_stay_in_the_well():
    random = np.random.default_rng(1)
    dark, bright, blinding = (
        instrument.detect(np.full(20_000, level), random) for level in (100.0, 10_000.0, 1e6)
    )

    assert 4 < dark.std() < 10
    assert bright.std() == pytest.approx((0.3 * 10_000) ** 0.5, rel=0.05)
    assert blinding.max() == instrument.FULL_WELL
