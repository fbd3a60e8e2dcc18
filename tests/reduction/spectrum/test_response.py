"""A response from a file, and what dividing it out makes of a spectrum."""

import numpy as np
import pytest

from labrun.reduction.spectrum.response import (
    KnownResponse,
    ResponseFault,
    read_response,
    write_response,
)
from labrun.reduction.spectrum.spectrum import Spectrum


def test_a_response_that_was_written_is_read_back(tmp_path):
    known = KnownResponse(np.array([200.0, 500.0]), np.array([0.25, 1.0]), np.array([0.1, 0.02]))
    write_response(known, tmp_path / "r.csv", ["made for a test"])
    text = (tmp_path / "r.csv").read_text()
    found = read_response(text)

    assert text.startswith("# made for a test\nwavelength_nm,response,error\n")
    for name in ("wavelength_nm", "response", "error"):
        assert getattr(found, name) == pytest.approx(getattr(known, name))


def test_counts_are_divided_by_it_and_the_notes_say_so():
    known = read_response("wavelength_nm,response\n200,5\n400,0.02\n500,20\n600,20\n")
    x = np.array([200.0, 400.0, 500.0, 600.0, 700.0])
    light = known.divided_out(Spectrum(x, np.full(5, 10.0), ("it was read",)))

    assert light.intensity[[0, 2, 3, 4]] == pytest.approx([40, 10, 10, 10])
    assert np.isnan(light.intensity[1])  # a thousandth of the greatest response
    assert light.notes == (
        "it was read",
        "the instrument's response was divided out",
        "the response is known from 200 to 600 nm; beyond, it is taken as at the ends",
        "1 channels with less than 1 % of the greatest response are left out",
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("# nothing\n\n", "it is empty"),
        ("nm,gain\n1,2\n", "line 1: no column wavelength_nm and response"),
        ("# card\nwavelength_nm,response\n200,high\n", "line 3: could not convert string"),
        ("wavelength_nm,response\n200,0\n", "line 2: wavelength and response must be numbers"),
        ("wavelength_nm,response\n200\n", "line 2: wavelength and response must be numbers"),
        ("wavelength_nm,response\n300,1\n200,1\n", "two wavelengths or more, in ascending order"),
    ],
)
def test_what_is_no_response_is_said_with_its_line(text, words):
    with pytest.raises(ResponseFault, match=words):
        read_response(text)
