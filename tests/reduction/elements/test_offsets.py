import numpy as np
import pytest

from labrun.reduction.elements.offsets import Offsets, estimate_offsets, seams
from labrun.reduction.lines.air import to_air

LINES = np.sort(np.random.default_rng(3).uniform(200, 900, 120))


def votes(peaks, medium=None, **more):
    ones = np.ones(len(LINES))
    return estimate_offsets(np.sort(peaks), np.ones(len(peaks)), LINES, ones, medium, 0.01, **more)


@pytest.mark.parametrize("offset", [-0.18, 0.0, 0.07, 0.2])
def test_one_offset_of_the_whole_axis_is_found(offset):
    best = votes(to_air(LINES[::2]) + offset)[0]

    assert best.medium == "air"
    assert best.at(np.array([250.0, 550.0, 850.0])) == pytest.approx([offset] * 3, abs=0.011)


def test_each_detector_has_its_own():
    true = to_air(LINES)
    best = votes(true + np.where(true < 500, 0.1, -0.06))[0]

    assert best.at(np.array([300.0, 460.0, 540.0, 800.0])) == pytest.approx(
        [0.1, 0.1, -0.06, -0.06], abs=0.011
    )


def test_a_vacuum_axis_is_told_from_air():
    assert votes(LINES[::2] + 0.03)[0].medium == "vacuum"
    assert votes(to_air(LINES[::2]) + 0.03)[0].medium == "air"
    assert votes(LINES[::2], "air")[0].medium == "air"


def test_a_seam_is_where_the_pitch_changes_at_once():
    bent = np.concatenate([np.arange(200, 400, 0.05), np.arange(400, 600, 0.06)])

    assert seams(bent) == pytest.approx([400], abs=0.5)
    assert len(seams(np.linspace(200, 900, 3_000))) == 0
    assert len(seams(200 + np.arange(3_000) * 0.1 + np.arange(3_000) ** 2 * 1e-6)) == 0


def test_where_two_detectors_overlap_both_ends_of_the_overlap_are_seams():
    axis = np.sort(np.concatenate([np.arange(300, 469, 0.0631), np.arange(439, 800, 0.1437)]))

    assert seams(axis) == pytest.approx([439, 469], abs=1.0)


def test_shown_is_true_plus_offset():
    offsets = Offsets("vacuum", np.array([500.0]), np.array([0.1, -0.1]), 0.0)

    assert offsets.shown(np.array([400.0, 600.0])) == pytest.approx([400.1, 599.9])
    assert Offsets.none("air").shown(np.array([670.961]))[0] == pytest.approx(670.776, abs=0.002)
