import numpy as np
import pytest

from labrun.reduction.maps.classes.minerals import brightness, likely

AREAS = {  # as the simulated analyser shows them, counts nm
    "spodumene": {"Li": 1800, "K": 1, "Na": 13, "Al": 1690, "Si": 2950, "H": 0},
    "quartz": {"Li": 30, "K": 4, "Na": 1, "Al": 50, "Si": 4200, "H": 0},
    "albite": {"Li": 20, "K": 5, "Na": 1300, "Al": 1300, "Si": 3200, "H": 0},
    "K-feldspar": {"Li": 10, "K": 550, "Na": 130, "Al": 1370, "Si": 3380, "H": 0},
    "muscovite": {"Li": 20, "K": 330, "Na": 75, "Al": 2290, "Si": 2200, "H": 80},
    "lepidolite": {"Li": 1600, "K": 320, "Na": 40, "Al": 1570, "Si": 2500, "H": 0},
}


def classes_of(minerals, elements=("Li", "K", "Na", "Al", "Si", "H"), n=10):
    areas = {
        e: np.concatenate([np.full(n, float(AREAS[m][e])) for m in minerals]) for e in elements
    }
    return areas, np.repeat(np.arange(len(minerals)), n)


def names(minerals, **how):
    areas, label = classes_of(minerals, **how)
    return [likely(bright)[0] for bright in brightness(areas, label, len(minerals))]


def test_each_mineral_of_a_pegmatite_gets_its_name():
    assert names(list(AREAS)) == list(AREAS)


@pytest.mark.parametrize("missing", list(AREAS))
def test_a_mineral_that_is_not_there_leaves_the_others_their_names(missing):
    there = [mineral for mineral in AREAS if mineral != missing]
    wrong = [(m, n) for m, n in zip(there, names(there), strict=True) if n not in (m, "unnamed")]

    assert wrong == []


def test_what_was_not_measured_names_nothing():
    assert names(["spodumene", "quartz"], elements=("Li", "H")) == ["unnamed", "unnamed"]


def test_a_mixture_of_two_minerals_gets_no_name():
    areas, label = classes_of(["spodumene", "albite", "K-feldspar"])
    label = np.where(label == 2, 1, label)

    assert likely(brightness(areas, label, 2)[1]) == ("unnamed", "")


def test_a_name_says_why():
    areas, label = classes_of(["spodumene", "albite"])

    assert likely(brightness(areas, label, 2)[1]) == ("albite", "Na bright, Li and K not")
