import numpy as np
import pytest

from labrun.reduction import Spectrum
from labrun.reduction.elements.evidence_score import BAD, NOT_SEEN
from labrun.reduction.elements.match import crowding, match_lines
from labrun.reduction.elements.offsets import Offsets
from labrun.reduction.lines.air import to_vacuum
from labrun.reduction.peaks.profiles import fit_profiles

PLACES = np.array([610.36, 670.78, 700.0, 812.6])


@pytest.fixture(scope="module")
def profiles():
    x = np.linspace(600, 820, 6_000)
    counts = np.random.default_rng(4).normal(100, 3, len(x))
    for centre in PLACES:
        counts += 400 * np.exp(-0.5 * ((x - centre - 0.05) / 0.06) ** 2)
    return fit_profiles(Spectrum(x, counts))


def matched(profiles, air_nm, bad=None, stark_nm=0.02):
    offsets = Offsets("air", np.array([650.0]), np.array([0.05, 0.05]), 0.0)
    air_nm = np.asarray(air_nm)
    bad = np.zeros(len(profiles.net), bool) if bad is None else bad
    return match_lines(
        profiles, profiles.wavelength_nm, bad, offsets, to_vacuum(air_nm), 0.01,
        np.full(len(air_nm), stark_nm),
    )  # fmt: skip


def test_every_line_finds_its_peak_in_any_order(profiles):
    order = [2, 0, 3, 1]
    found = matched(profiles, PLACES[order])

    assert found.shown_nm == pytest.approx(PLACES[order] + 0.05, abs=1e-6)
    assert profiles.peaks.centre_nm[found.peak] == pytest.approx(PLACES[order] + 0.05, abs=0.01)
    assert np.all(found.away < 3.2)


def test_a_line_without_a_peak_and_one_outside_say_so(profiles):
    assert matched(profiles, [640.0, 500.0]).peak.tolist() == [NOT_SEEN, BAD]


def test_a_line_on_a_bad_channel_has_no_say(profiles):
    bad = np.abs(profiles.wavelength_nm - 640.05) < 0.1

    assert matched(profiles, [640.0], bad).peak.tolist() == [BAD]


def test_a_broad_line_must_be_brighter_to_be_missed(profiles):
    narrow, broad = (matched(profiles, [640.0], stark_nm=w).limit[0] for w in (0.02, 1.0))

    assert broad > 3 * narrow
    assert narrow == pytest.approx(3 * 3.0 * 1.0645 * 0.141 * 1.15, rel=0.25)


def test_crowding_counts_peaks_for_each_nanometre():
    assert crowding(np.array([100.0, 101.0, 102.0, 300.0])) == pytest.approx([0.5, 0.5, 0.5, 1 / 6])


def test_light_at_its_place_hides_a_line_up_to_its_brightness(profiles):
    """A strong line that reverses itself has no peak in its middle, and yet is not missing."""
    hidden = np.exp(matched(profiles, [640.0, 670.90]).log_hidden)

    assert hidden[0] < 2 * 3 * 3.0 * 1.0645 * 0.141 * 1.15
    assert hidden[1] > 4 * hidden[0]
