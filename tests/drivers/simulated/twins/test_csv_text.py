"""The analyser's CSV says each number as Python would, only sooner."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrun.drivers.simulated.twins.csv_text import CsvText

AXIS = np.array([190.0, 190.0333, 670.78, 949.99996])


@given(st.lists(st.floats(0, 99_999.9), min_size=4, max_size=4))
def test_numbers_are_written_with_one_decimal_and_no_zeros_in_front(counts):
    text = CsvText(AXIS).write(np.array(counts)).decode()
    header, *rows = text.splitlines()
    tenths = [int(t) for t in np.rint(np.array(counts) * 10)]

    assert header == "wavelength,intensity"
    assert rows == [f"{x:.4f},{t // 10}.{t % 10}" for x, t in zip(AXIS, tenths, strict=True)]


def test_an_axis_whose_numbers_are_of_several_lengths_is_refused():
    with pytest.raises(ValueError, match=r"100\.0000 to 999\.9999"):
        CsvText(np.array([99.0, 100.0]))
