"""A spectrum has one reduction, whoever reduces it: alone, in a thread, or in another process."""

import hashlib
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import pytest

from labrun.reduction import Spectrum, read_spectrum, reduce_spectrum

NUMBERS = (0, 3, 4, 9)


def digest(value, into=None):
    """A hash over every bit of a result, through all that it is made of."""
    into = hashlib.sha256() if into is None else into
    if is_dataclass(value):
        for field in fields(value):
            into.update(field.name.encode())
            digest(getattr(value, field.name), into)
    elif isinstance(value, np.ndarray):
        into.update(np.ascontiguousarray(value).tobytes())
    elif isinstance(value, dict):
        for key in value:
            into.update(str(key).encode())
            digest(value[key], into)
    elif isinstance(value, list | tuple):
        for one in value:
            digest(one, into)
    else:
        into.update(repr(value).encode())
    return into.hexdigest()


@pytest.fixture(scope="module")
def spectra(tmp_path_factory, reduced):
    folder = tmp_path_factory.mktemp("spectra")
    paths = []
    for number in NUMBERS:
        truth, _ = reduced("train", number)
        paths.append(folder / f"{number}.npy")
        np.save(paths[-1], np.vstack([truth.wavelength_nm, truth.intensity]))
    return paths


@pytest.fixture(scope="module")
def alone(spectra):
    return [digest(reduce_spectrum(read_spectrum(path))) for path in spectra]


@pytest.mark.soak
def test_again_and_in_another_order(spectra, alone):
    again = [digest(reduce_spectrum(read_spectrum(path))) for path in reversed(spectra)]

    assert again[::-1] == alone


@pytest.mark.soak
def test_in_four_threads_at_once(spectra, alone):
    many = spectra * 4
    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(lambda path: digest(reduce_spectrum(read_spectrum(path))), many))

    assert found == alone * 4


@pytest.mark.soak
@pytest.mark.parametrize("threads", ["1", "3"])
def test_in_another_process_with_other_numbers_of_threads(spectra, alone, threads):
    program = (
        "import sys; sys.path[:0] = sys.argv[1].split('|')\n"
        "from test_same_bits import digest\n"
        "from labrun.reduction import read_spectrum, reduce_spectrum\n"
        "for path in sys.argv[2:]: print(digest(reduce_spectrum(read_spectrum(path))))\n"
    )
    own = {
        "OMP_NUM_THREADS": threads,
        "OPENBLAS_NUM_THREADS": threads,
        "NUMBA_NUM_THREADS": threads,
    }
    answer = subprocess.run(
        [sys.executable, "-c", program, str(Path(__file__).parent), *map(str, spectra)],
        capture_output=True, text=True, env={**os.environ, **own},
    )  # fmt: skip

    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.split() == alone


@pytest.mark.slow
def test_one_bit_more_is_another_digest(spectra, alone):
    spectrum = read_spectrum(spectra[0])
    counts = spectrum.intensity.copy()
    counts[len(counts) // 2] += 1.0

    assert digest(reduce_spectrum(Spectrum(spectrum.wavelength_nm, counts))) != alone[0]
