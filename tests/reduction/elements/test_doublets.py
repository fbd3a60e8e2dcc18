import numpy as np
import pytest

from labrun.reduction.elements.doublets import DOUBLETS, _lines, light_lost, self_absorbed
from labrun.reduction.plasma.strengths import atoms


@pytest.mark.parametrize("doublet", DOUBLETS, ids=lambda d: d.name)
def test_both_lines_of_each_doublet_are_in_the_table(doublet):
    strong, weak = (_lines(doublet.element, nm) for nm in (doublet.strong_nm, doublet.weak_nm))

    assert len(strong[0]) and len(weak[0])
    assert np.exp(strong[0]).sum() > np.exp(weak[0]).sum()


def test_light_that_was_lost_is_told(reduced):
    _, found = reduced("train", 2)
    names = {str(atoms().elements[e]) for e in found.identified.indexed.accepted}
    lost = [light_lost(d, found.peaks, found.identified) for d in DOUBLETS if d.element in names]

    assert any(lost)
    assert all("absorbs itself" in text for text in self_absorbed(found.peaks, found.identified))
