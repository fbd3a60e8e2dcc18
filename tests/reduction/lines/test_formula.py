"""Elements and oxides, against molar masses worked out by hand."""

import pytest

from labrun.reduction.lines.formula import WEIGHT, element_in
from labrun.reduction.lines.symbols import SYMBOLS


@pytest.mark.parametrize(
    ("formula", "element", "part"),
    [("Li", "Li", 1.0), ("SiO2", "Si", 0.46744), ("Li2O", "Li", 0.46456), ("Fe2O3", "Fe", 0.69944),
     ("P2O5", "P", 0.43643), ("O", "O", 1.0)],
)  # fmt: skip
def test_an_oxide_has_so_much_of_its_element(formula, element, part):
    assert element_in(formula) == (element, pytest.approx(part, rel=2e-4))


@pytest.mark.parametrize("text", ["CaCO3", "Xx", "lithium", "", "Li2", "O2", "si", "H2Ox"])
def test_what_is_neither_is_refused(text):
    with pytest.raises(ValueError, match="element"):
        element_in(text)


def test_weights_are_of_elements_and_ascend_but_where_nature_does_not():
    assert set(WEIGHT) <= SYMBOLS
    falls = [a for a, b in zip(WEIGHT, list(WEIGHT)[1:], strict=False) if WEIGHT[b] < WEIGHT[a]]

    assert falls == ["Co", "Te"]
