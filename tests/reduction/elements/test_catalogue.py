import numpy as np

from labrun.reduction.elements.abundance_prior import log_odds
from labrun.reduction.elements.catalogue import MOST, catalogue
from labrun.reduction.plasma.strengths import atoms

WHOLE = catalogue(190.0, 961.0, 0.05)


def test_every_element_has_its_strongest_lines_first():
    a = atoms()
    sodium = a.elements.tolist().index("Na")
    leader = WHOLE.leader[WHOLE.first[sodium]]

    assert 588 < a.wavelength_nm[leader] < 590.5
    assert np.all(np.diff(WHOLE.first) <= MOST)


def test_what_the_instrument_cannot_part_is_one_entry():
    coarse = catalogue(190.0, 961.0, 0.4)
    expected = WHOLE.strengths(10_000.0, 1e17)
    lithium = atoms().elements.tolist().index("Li")
    first = WHOLE.first[lithium]

    assert len(coarse.leader) < len(WHOLE.leader)
    assert expected.vacuum_nm[first] == np.clip(expected.vacuum_nm[first], 670.95, 670.98)


def test_a_range_without_lines_of_an_element_has_no_entry_of_it():
    narrow = catalogue(580.0, 600.0, 0.05)
    lithium = atoms().elements.tolist().index("Li")

    assert narrow.first[lithium + 1] - narrow.first[lithium] <= 3


def test_radioactive_elements_need_the_most_evidence():
    names, odds = atoms().elements.tolist(), log_odds()

    assert odds[names.index("Tc")] < odds[names.index("Tm")] < odds[names.index("Li")] == 0
