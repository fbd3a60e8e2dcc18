"""A driver, twin and test that labrun 0.1 wrote still run, and say where their imports are now."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

FILES = Path(__file__).parent / "written_by_0_1"
MOVED = {
    "serial_line": "serial_io.line",
    "serial_port": "serial_io.port",
    "twins.twin": "simulated.twins.twin",
}


@pytest.fixture(scope="module")
def output(tmp_path_factory):
    folder = tmp_path_factory.mktemp("written_by_0_1")
    for file in FILES.glob("*.txt"):
        (folder / file.stem).write_bytes(file.read_bytes())
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_furnace.py",
         "-k", "good or describes"],
        cwd=folder, capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    return done.stdout


def test_driver_and_twin_keep_their_contract(output):
    assert " passed" in output and "failed" not in output


@pytest.mark.parametrize("old", MOVED)
def test_an_import_by_the_old_name_warns_with_the_new_one(output, old):
    assert f"labrun.drivers.{old} is now labrun.drivers.{MOVED[old]}" in output


@pytest.mark.parametrize("old", MOVED)
def test_both_names_mean_the_same_class(old):
    program = (
        "import warnings; warnings.simplefilter('ignore')\n"
        f"import labrun.drivers.{old} as old, labrun.drivers.{MOVED[old]} as new\n"
        "own = [n for n, v in vars(new).items() if getattr(v, '__module__', '') == new.__name__]\n"
        "assert own and all(getattr(old, n) is getattr(new, n) for n in own), own"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)

    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", ["serial_line", "serial_port", "twins"])
def test_a_module_of_somebody_else_is_not_taken_for_ours(name):
    program = f"import labrun.drivers\nimport {name}"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)

    assert f"ModuleNotFoundError: No module named '{name}'" in done.stderr
