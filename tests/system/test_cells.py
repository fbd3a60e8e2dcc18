"""Text is written so that no spreadsheet computes it, and read back as it was."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrun.system.cells import bare, guarded


@pytest.mark.parametrize(
    "text", ["=cmd|' /C calc'!A0", "@SUM(1)", "+1+cmd", "-2+3+cmd|x", "\t=1", "'=1"]
)
def test_a_formula_is_text(text):
    assert guarded(text) == f"'{text}"


@pytest.mark.parametrize(
    "text", ["", "-4.25", "+1e-3", "-4,1", "grain 1", "'quoted'", "12:30", "µ=3"]
)
def test_numbers_and_words_stay_as_they_are(text):
    assert guarded(text) == text == bare(text)


@given(st.text(alphabet="'=+-@\t\r1.,eab "))
def test_every_text_comes_back(text):
    assert bare(guarded(text)) == text
