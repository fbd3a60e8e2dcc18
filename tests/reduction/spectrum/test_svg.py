"""A spectrum shows itself: its outline keeps every peak, a bad channel is a gap."""

import re

import numpy as np

from labrun.reduction.spectrum.spectrum import Spectrum


def drawn(counts, notes=()):
    nm = np.linspace(200.0, 900.0, len(counts))
    return Spectrum(nm, np.asarray(counts, float), notes)._repr_html_()


def test_a_peak_of_one_channel_among_22_800_is_drawn_to_its_height():
    counts = np.ones(22_800)
    counts[12_345] = 5000.0
    svg = drawn(counts)

    assert "V0.0" in svg and "at most 5000 counts" in svg
    assert "200.0 nm" in svg and "900.0 nm" in svg
    assert len(svg) < 30_000


def test_a_bad_channel_is_a_gap_and_notes_are_told_as_text():
    svg = drawn([1, 2, np.nan, 3, 4], notes=("<b>saturated</b>",))

    assert len(re.findall("M", re.findall("d='(.*?)'", svg)[0])) == 2
    assert "&lt;b&gt;saturated" in svg
    assert "without a good channel" in drawn([np.nan])
