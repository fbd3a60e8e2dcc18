"""The simulated core is always the same rock, with all its minerals in the demonstration window."""

from collections import Counter

import numpy as np
import pytest

from labrun.drivers.simulated.twins.core import HEIGHT_MM, WIDTH_MM, Core
from labrun.drivers.simulated.twins.minerals import (
    BY_NAME,
    ELEMENTS,
    MASS,
    MINERALS,
    atom_fractions,
)

WINDOW = np.meshgrid(np.arange(0, 4.01, 0.2), np.arange(0, 10.01, 0.2))


def minerals_in(core: Core, x: np.ndarray, y: np.ndarray) -> Counter[str]:
    kinds = core.kind.ravel()[core.grain_at(x, y)]
    return Counter(MINERALS[kind].name for kind in kinds.ravel())


def test_the_window_of_the_demonstration_shows_all_six_minerals():
    shown = minerals_in(Core(), *WINDOW)

    assert set(shown) == set(BY_NAME)
    assert min(shown.values()) >= 20
    assert max(shown.values()) < 1071 / 2


def test_the_same_seed_is_the_same_rock_and_another_is_another():
    one, same, other = (Core(seed).grain_at(*WINDOW) for seed in (3, 3, 4))

    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_grains_are_half_a_millimetre_to_three_in_size():
    x, y = np.meshgrid(np.arange(2, 22, 0.1), np.arange(2, 22, 0.1))
    _, counts = np.unique(Core().grain_at(x, y), return_counts=True)
    diameters = 2 * np.sqrt(counts * 0.01 / np.pi)

    assert 1.0 < np.median(diameters) < 1.5
    assert np.percentile(diameters, 99) < 3.0


def test_the_whole_core_is_rock_and_beside_it_is_none():
    core = Core()
    corners = [(0, 0), (WIDTH_MM, 0), (0, HEIGHT_MM), (WIDTH_MM, HEIGHT_MM)]

    assert all(core.holds(x, y) and core.mineral_at(x, y) in BY_NAME for x, y in corners)
    assert not core.holds(-0.1, 0)
    assert not core.holds(WIDTH_MM + 0.1, 0)


def test_a_place_is_made_of_about_what_its_mineral_is_made_of():
    core = Core()
    lithium = ELEMENTS.index("Li")
    for x, y in zip(*(axis.ravel()[::17] for axis in WINDOW), strict=True):
        atoms = core.composition_at(x, y)
        pure = atom_fractions(core.mineral_at(x, y)).get("Li", 0.0)

        assert atoms.sum() == pytest.approx(1)
        assert atoms[lithium] == pytest.approx(pure, rel=0.7)


def test_the_surface_is_flat_to_a_few_hundredths():
    core = Core()
    heights = [core.height_at(x, y) for x, y in zip(*map(np.ravel, WINDOW), strict=True)]

    assert 0.01 < max(heights) - min(heights) < 0.12


@pytest.mark.parametrize(
    ("mineral", "element", "percent"),
    [  # from the ideal formulas, as mineralogical tables give them
        ("spodumene", "Li", 3.73),
        ("quartz", "Si", 46.74),
        ("albite", "Na", 8.77),
        ("K-feldspar", "K", 14.05),
        ("muscovite", "K", 9.82),
        ("lepidolite", "Li", 3.0),
    ],
)
def test_minerals_weigh_in_as_the_tables_say(mineral, element, percent):
    grams = {e: share * MASS[e] for e, share in atom_fractions(mineral).items()}

    assert 100 * grams[element] / sum(grams.values()) == pytest.approx(percent, rel=0.05)


@pytest.mark.parametrize("mineral", MINERALS, ids=lambda m: m.name)
def test_formulas_are_neutral(mineral):
    charges = {"H": 1, "Li": 1, "Na": 1, "K": 1, "Al": 3, "Si": 4, "O": -2, "F": -1}

    assert sum(charges[e] * n for e, n in mineral.atoms.items()) == pytest.approx(0)
