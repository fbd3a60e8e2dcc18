"""Compiled code lies in the user's cache, never beside the module."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import labrun.reduction
from labrun.reduction.peaks.windows import half_heights
from labrun.reduction.spectrum import kernel
from labrun.reduction.spectrum.kernel import ByContents, CompiledOnce, state_of
from labrun.system.files import lock_file

PACKAGE = Path(labrun.reduction.__file__).parent


def test_code_compiled_before_a_source_changed_is_not_taken_for_that_of_now(tmp_path):
    caller, called = tmp_path / "peaks" / "fit.py", tmp_path / "lines" / "air_kernel.py"
    for path in (caller, called):
        path.parent.mkdir()
        path.write_text("pass\n")
    before = state_of(tmp_path)
    called.write_text("pass  # changed\n")

    assert state_of(tmp_path) != before
    assert state_of(tmp_path) == state_of(tmp_path)


def test_the_same_code_installed_elsewhere_is_not_compiled_again(tmp_path):
    elsewhere = tmp_path / "labrun" / "reduction"
    shutil.copytree(PACKAGE, elsewhere, ignore=shutil.ignore_patterns("__pycache__", "*.npz"))
    loop, within = half_heights.py_func, Path("peaks") / "windows.py"

    assert state_of(elsewhere) == state_of(PACKAGE)
    assert ByContents.get_suitable_cache_subpath(elsewhere / within) == "peaks"
    assert ByContents.from_function(loop, str(elsewhere / within)) is None  # not of this labrun
    assert (
        Path(ByContents.from_function(loop, str(PACKAGE / within)).get_cache_path()).name == "peaks"
    )


def test_every_compiled_loop_lies_where_changes_are_looked_for():
    with_loops = {
        path for path in PACKAGE.rglob("*.py") if "kernel\ndef " in path.read_text(encoding="utf-8")
    }

    assert len(with_loops) > 10
    assert with_loops <= set(PACKAGE.glob("*/*.py"))


def test_who_compiles_a_loop_has_it_alone_until_it_is_done_or_failed(tmp_path, monkeypatch):
    monkeypatch.setattr(kernel.config, "CACHE_DIR", str(tmp_path))
    own, loop = half_heights, half_heights.py_func
    sig = ((kernel.numba.float64[::1], kernel.numba.int64), None)
    one, other = CompiledOnce(loop), CompiledOnce(loop)
    waited = []
    monkeypatch.setattr(kernel, "_wait_for", lambda file: waited.append(locked(file)))

    assert one.load_overload(sig, own.targetctx) is None  # it is to be compiled, by this one
    assert other.load_overload(sig, own.targetctx) is None  # its patience has ended
    other.unlock()
    one.unlock()
    assert other.load_overload(sig, own.targetctx) is None
    other.unlock()

    assert waited == [True, False, True]


def locked(file):
    try:
        lock_file(file)
    except OSError:
        return False
    return True


@pytest.mark.soak
def test_two_processes_that_want_a_loop_at_once_compile_it_once(tmp_path):
    program = (
        "import numpy as np\n"
        "from labrun.reduction.peaks.windows import widths\n"
        "from numba.core import event\n"
        "with event.install_recorder('numba:compile') as seen:\n"
        "    widths(np.ones(9), np.array([4]))\n"
        "print(sum(e.is_start for _, e in seen.buffer))\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    both = [
        subprocess.Popen(
            [sys.executable, "-P", "-c", program],
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )
        for _ in range(2)
    ]
    compiled = sorted(int(process.communicate()[0]) for process in both)

    assert compiled[0] == 0
    assert compiled[1] >= 3  # widths, and what it calls


@pytest.mark.soak
def test_compiling_leaves_nothing_in_the_package(tmp_path):
    program = (
        "import numpy as np\n"
        "from labrun.reduction.peaks.snip import __file__ as place\n"
        "from labrun.reduction import Spectrum\n"
        "from labrun.reduction.peaks.background import background\n"
        "background(Spectrum(np.linspace(200.0, 300.0, 500), np.ones(500)))\n"
    )
    environment = {"PATH": "", "HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    package = PACKAGE
    before = set(package.rglob("*.nbi"))

    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True,
        env={**environment, "PYTHONPATH": str(package.parents[1])},
    )  # fmt: skip

    assert done.returncode == 0, done.stderr
    assert set(package.rglob("*.nbi")) == before
    assert list((tmp_path / "cache" / "labrun" / "numba").rglob("*.nbi"))
