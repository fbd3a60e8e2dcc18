from io import BytesIO

import numpy as np
import pytest

from labrun.reduction import Unreadable, read_shots, read_spectrum

X = np.linspace(200, 300, 50)
TWO = np.stack([np.arange(50) + 3.0, np.arange(50) + 5.0])


def npy(table):
    file = BytesIO()
    np.save(file, table)
    return file.getvalue()


def test_shots_are_kept_or_averaged():
    text = "nm,one,two\n" + "".join(f"{x},{a},{b}\n" for x, a, b in zip(X, *TWO, strict=True))
    shots = read_shots(text.encode())

    assert len(shots) == 2 and shots.each()[1].intensity[0] == 5
    assert shots.mean().intensity.tolist() == list(np.arange(50) + 4.0)


@pytest.mark.parametrize("turn", [lambda t: t, lambda t: t.T])
def test_npy_may_lie_either_way(turn):
    shots = read_shots(npy(turn(np.vstack([X, TWO]))))

    assert shots.wavelength_nm == pytest.approx(X)
    assert shots.intensity.shape == (2, 50)
    assert read_spectrum(npy(turn(np.vstack([X, TWO])))).intensity[0] == 4


def test_a_channel_that_is_bad_in_one_shot_is_the_others():
    table = np.vstack([X, TWO])
    table[1, 7] = np.nan

    assert read_shots(npy(table)).mean().intensity[7] == 12


def test_descending_and_doubled_wavelengths_are_put_in_order():
    shots = read_shots(b"202 1\n201 2\n201 9\n200 3\n")

    assert shots.wavelength_nm.tolist() == [200, 201, 202]
    assert shots.intensity[0].tolist() == [3, 5.5, 1]


@pytest.mark.parametrize(
    ("raw", "sentence"),
    [
        (b"", "is empty"),
        (b"nm,counts\n", "is empty"),
        (b"200\n201\n", "line 1 has one column"),
        (b"200,1\n201,1,2\n", "line 2 has 3 columns"),
        (b"200,1\n201,dark\n", "line 2 is not two numbers"),
        (b"\xff\xfe\x00", "UTF-16, but broken"),
        (npy(np.ones((2, 3, 4))), "shape"),
        (b"\x93NUMPY\x01\x00broken", "cannot be read"),
    ],
)
def test_what_is_no_table_of_shots_is_refused_with_a_sentence(raw, sentence):
    with pytest.raises(Unreadable, match=sentence):
        read_shots(raw)
