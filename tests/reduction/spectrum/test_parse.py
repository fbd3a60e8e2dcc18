import numpy as np

from labrun.reduction.spectrum.read import read_spectrum

COUNTS = (
    "5",
    "-3",
    "0.25",
    "-12.5",
    "1234567890.125",
    "7.",
    ".5",
    "1e3",
    "12345678901234567890",
    "nan",
)


def test_plain_lines_and_all_others_are_read_as_the_same_numbers():
    rows = [(f"{200 + k / 8}", COUNTS[k % len(COUNTS)]) for k in range(300)]
    quick, spaced = ("".join(f"{x}{mark}{y}\n" for x, y in rows) for mark in (",", "  "))
    wanted = np.array([float(y) for _, y in rows])

    for text in (quick, spaced, quick.replace("\n", "\r\n"), quick.replace(",", "\t").rstrip()):
        found = read_spectrum(text.encode())
        assert found.wavelength_nm.tolist() == [float(x) for x, _ in rows]
        np.testing.assert_allclose(found.intensity, wanted, rtol=1e-15)
