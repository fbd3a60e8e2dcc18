"""Real spectra in real folders: shots at the simulated core."""

import os
from pathlib import Path

import pytest

from labrun.drivers.simulated.twins.shot import ShotMaker
from labrun.reduction.tables.write import file_names

PLACES = [(0.4, 1.0), (1.2, 3.0), (2.0, 5.0), (2.8, 7.0), (3.6, 9.0), (1.6, 8.0)]


@pytest.fixture(scope="session")
def shots() -> list[bytes]:
    maker = ShotMaker(core=1, seed=3)
    return [maker.csv({"n": n, "x": x, "y": y, "focus": 1.0}) for n, (x, y) in enumerate(PLACES)]


@pytest.fixture
def spectra(tmp_path, shots) -> Path:
    """A folder of six spectra, `core_0.csv` to `core_10.csv` in steps of two."""
    folder = tmp_path / "spectra"
    folder.mkdir()
    for n, shot in enumerate(shots):
        (folder / f"core_{2 * n}.csv").write_bytes(shot)
    age(folder)
    return folder


@pytest.fixture
def many(tmp_path, shots) -> Path:
    """A folder of 600 names for the same six spectra."""
    folder = tmp_path / "many"
    folder.mkdir()
    for n, shot in enumerate(shots):
        (folder / f"s_{n}.csv").write_bytes(shot)
        for copy in range(1, 100):
            os.link(folder / f"s_{n}.csv", folder / f"s_{n}_{copy}.csv")
    age(folder)
    return folder


def age(folder: Path) -> None:
    """Make all files an hour old, so that nobody waits whether they still grow."""
    for file in folder.rglob("*"):
        if file.is_file():
            then = file.stat().st_mtime - 3600
            os.utime(file, (then, then))


@pytest.fixture
def tables_of():
    """The bytes of all tables in a folder, by name."""
    return lambda folder: {name: (folder / name).read_bytes() for name in file_names()}
