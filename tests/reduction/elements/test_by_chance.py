import numpy as np
import pytest

from labrun.reduction import Spectrum, reduce_spectrum
from labrun.reduction.elements.evidence import ALONE, _least
from labrun.reduction.elements.index import DETECTED
from labrun.reduction.plasma.strengths import atoms


def forest(seed: int) -> Spectrum:
    """900 lines at random places, of no element: three in a nanometre."""
    rng = np.random.default_rng(seed)
    x = np.linspace(250.0, 520.0, 6_000)
    places, heights = rng.uniform(251, 519, 900), np.exp(rng.uniform(3.5, 8, 900))
    counts = 100 + rng.normal(0, 4, len(x))
    for at, high in zip(places.tolist(), heights.tolist(), strict=True):
        near = slice(*np.searchsorted(x, [at - 1, at + 1]))
        counts[near] += high * np.exp(-0.5 * ((x[near] - at) / 0.05) ** 2)
    return Spectrum(x, counts)


@pytest.mark.parametrize("seed", [1, 6, 10])
def test_cerium_is_not_detected_among_lines_of_no_element(seed):
    found = reduce_spectrum(forest(seed))
    cerium = found.evidence["Ce"]

    assert cerium.score > 4 * DETECTED  # the lines that fall on peaks by chance are many
    assert cerium.status == "uncertain"


def test_where_hardly_any_light_is_explained_no_element_is_everywhere_and_a_note_asks_why():
    found = reduce_spectrum(forest(12))

    assert found.detected == []
    assert found.notes[-1].startswith("the elements found explain 2% of the light")


def test_an_axis_is_not_moved_to_where_few_lines_agree():
    found = reduce_spectrum(forest(0))  # 130 in weight at -2.42 nm, of lines that coincide

    assert not any("far off" in note for note in found.notes)


@pytest.mark.parametrize(
    ("name", "beside", "least"),
    [("Dy", "Ca", ALONE), ("Dy", "Y", DETECTED), ("La", "La", ALONE), ("Hf", "Zr", DETECTED),
     ("Sn", "Ca", DETECTED)],
)  # fmt: skip
def test_an_element_without_its_company_needs_more(name, beside, least):
    above = np.where(atoms().elements == beside, 50.0, 0.0)

    assert _least(name, above, certain=True) == least
