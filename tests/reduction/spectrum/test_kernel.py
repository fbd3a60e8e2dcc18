"""Compiled code lies in the user's cache, never beside the module."""

import subprocess
import sys
from pathlib import Path

import pytest

import labrun.reduction


@pytest.mark.slow
def test_compiling_leaves_nothing_in_the_package(tmp_path):
    program = (
        "import numpy as np\n"
        "from labrun.reduction.peaks.snip import __file__ as place\n"
        "from labrun.reduction import Spectrum\n"
        "from labrun.reduction.peaks.background import background\n"
        "background(Spectrum(np.linspace(200.0, 300.0, 500), np.ones(500)))\n"
    )
    environment = {"PATH": "", "HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    package = Path(labrun.reduction.__file__).parent
    before = set(package.rglob("*.nbi"))

    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True,
        env={**environment, "PYTHONPATH": str(package.parents[1])},
    )  # fmt: skip

    assert done.returncode == 0, done.stderr
    assert set(package.rglob("*.nbi")) == before
    assert list((tmp_path / "cache" / "labrun" / "numba").rglob("*.nbi"))
