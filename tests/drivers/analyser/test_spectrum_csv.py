"""A spectrum that is cut off anywhere is told from a whole one."""

import contextlib

import pytest

from labrun.drivers.analyser.spectrum_csv import Incomplete, judged

ROWS = [f"{190 + k / 10:.4f},{k % 7}.5" for k in range(500)]


def text(rows=ROWS, head=("wavelength,intensity",), end="\n") -> bytes:
    return (end.join([*head, *rows]) + end).encode()


@pytest.mark.parametrize(
    "data",
    [
        text(),
        text(end="\r\n"),
        text(head=()),
        text(head=("SciAps Z-300", "Serial;915", "", "wavelength;intensity")),
        text([row.replace(",", "\t") for row in ROWS]),
        b"\xef\xbb\xbf" + text(),
        text([f"{row},extra" for row in ROWS]),
        text() + b"\n\n",
        text()[:-1],
    ],
)
def test_whole_spectra_of_several_programs(data):
    assert judged(data).channels == 500


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "still empty"),
        (text()[:-2], "it ends within line 501"),
        (text()[:5004], "it ends within line"),
        (text(ROWS[:50]), "only 50 channels"),
        (b"wavelength,intensity\n", "contain no wavelength"),
        (text([*ROWS, "oops"]), "line 502 is not a wavelength and an intensity: 'oops'"),
        (b"\xff\xfe\x00", "not text"),
        (text([*ROWS[:200], "nan,1", *ROWS[200:]]), "line 202"),
        (text([f"{190 + k / 10:.4f},0" for k in range(500)]), "every intensity is 0: the detector"),
        (text([f"{190 + k / 10:.4f},nan" for k in range(500)]), "every intensity is no number"),
        (
            text([f"400.0,{k}" for k in range(500)]),
            "500 channels have only 1 different wavelengths",
        ),
        (text(ROWS, head=("pixel,raw",)), "columns are pixel, raw: it has no wavelengths"),
        (text([f"{k},{k % 7}.5" for k in range(500)]), "first column counts channels"),
        (text([f"{k},{k % 7}.5" for k in range(1, 1501)]), "first column counts channels"),
    ],
)
def test_what_is_not_whole_says_why(data, words):
    with pytest.raises(Incomplete, match=words):
        judged(data)


def test_a_cut_at_any_byte_never_passes_for_the_whole():
    data = text()
    counts = []
    for length in range(2000, len(data) - 2, 7):
        with contextlib.suppress(Incomplete):
            counts.append(judged(data[:length]).channels)

    assert counts and max(counts) < 500
