import io

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from labrun.reduction import Unreadable, read_spectrum

PLAIN = st.floats(1e-6, 1e12).map(lambda value: float(f"{value:.12g}"))
WAVELENGTH = st.floats(150, 2_500).map(lambda value: float(f"{value:.12g}"))


def test_a_sciaps_export_is_read_as_numpy_reads_it(make_truth):
    truth = make_truth([(500.0, 670.78, 0.06, 0.02)], channels=2_000)
    rows = zip(truth.wavelength_nm, truth.intensity, strict=True)
    text = "wavelength,intensity\n" + "".join(f"{x:.4f},{y:.3f}\n" for x, y in rows)
    spectrum = read_spectrum(text.encode())
    known = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1)

    assert np.array_equal(spectrum.wavelength_nm, known[:, 0])
    assert np.array_equal(spectrum.intensity, known[:, 1])


def test_a_file_is_read_by_its_path(tmp_path):
    path = tmp_path / "shot.csv"
    path.write_bytes(b"\xef\xbb\xbfwavelength,intensity\r\n200.0,1\r\n200.5,2e3\r\n")

    assert read_spectrum(path).intensity.tolist() == [1.0, 2000.0]


@pytest.mark.parametrize(
    "text",
    [
        b"200,1\n201,-2\n",
        b"200;1\n201;-2",
        b"200\t1\n\n201\t-2\n",
        b"# analyser 3\nnm counts\n200 1\n201 -2\n",
        b" 200 , 1 , 7\n+2.01e2,-2.,x\n",
        b"200,1\n201,-2\nDate: today\n",
    ],
)
def test_separators_comments_and_further_columns_are_understood(text):
    spectrum = read_spectrum(text)

    assert spectrum.wavelength_nm.tolist() == [200.0, 201.0]
    assert spectrum.intensity.tolist() == [1.0, -2.0]


@given(
    st.lists(st.tuples(WAVELENGTH, PLAIN), min_size=1, max_size=20, unique_by=lambda row: row[0])
)
def test_numbers_are_those_that_python_reads(rows):
    rows = sorted(rows)
    assume(len({y for _, y in rows}) > 1 or len(rows) == 1)  # a level one is refused
    text = "\n".join(f"{x!r},{y!r}" for x, y in rows)
    spectrum = read_spectrum(text.encode(), unit="nm")

    assert spectrum.wavelength_nm.tolist() == [x for x, _ in rows]
    assert spectrum.intensity.tolist() == [y for _, y in rows]


def test_more_digits_than_a_double_holds_are_read_to_the_last_bit_but_one():
    text = b"200.123456789012345678901,0.30000000000000004441\n201,12345678901234567890123\n"
    spectrum = read_spectrum(text)

    assert spectrum.wavelength_nm[0] == pytest.approx(200.12345678901234, rel=4e-16)
    assert spectrum.intensity.tolist() == pytest.approx([0.3, 1.2345678901234567e22], rel=4e-16)


def test_rows_out_of_order_are_sorted_and_equal_wavelengths_averaged():
    spectrum = read_spectrum(b"201,5\n200,1\n201,7\n200.5,2\n")

    assert spectrum.wavelength_nm.tolist() == [200.0, 200.5, 201.0]
    assert spectrum.intensity.tolist() == [1.0, 2.0, 6.0]


def test_bad_channels_are_marked_with_nan():
    spectrum = read_spectrum(b"200,1\n201,NaN\n202,\n203,inf\n204,1e-300\n")

    assert np.isnan(spectrum.intensity).tolist() == [False, True, True, True, False]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (b"", "is empty"),
        (b"wavelength,intensity\n\n", "is empty"),
        (b"wavelength,intensity\n200,1\n201\n", "line 3 has one column"),
        (b"wavelength,intensity\n200,1\n201,dark\n", "line 3 is not two numbers: '201,dark'"),
        (b"200,1\nnan,3\n", "line 2 has no wavelength"),
        (b"200,1\n201,\xff\xd8\xff\n", "line 2 is not two numbers"),
        (b"200,nan\n201,nan\n", "no numeric intensity"),
        (b"200,1e\n", "line 1 is not two numbers"),
    ],
)
def test_what_is_no_spectrum_is_refused_with_its_line(text, sentence):
    with pytest.raises(Unreadable, match=sentence):
        read_spectrum(text)
