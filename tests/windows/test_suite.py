"""The tests of engine, device servers and system, each folder once more under Windows' rules.

By hand: `LABRUN_WINDOWS_RULES=1 pytest tests/engine/runner`.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
FOLDERS = (
    "engine/journal", "engine/run", "engine/dispatch", "drivers/client", "drivers/server",
    "engine/commands", "engine/control", "engine/runner", "drivers/balance",
    "drivers/bridges/test_scpi.py", "drivers/messenger", "drivers/bridges/test_text.py",
    "drivers/bridges/test_modbus.py",
)  # fmt: skip
"""Those of 10 to 45 s of a processor each."""

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the real one has them itself")


def under_the_rules(folder: str, place: Path) -> subprocess.CompletedProcess[str]:
    # In a place of its own: among several processes pytest once left a folder's listing open.
    quiet = ["-p", "no:xdist", "-p", "no:cacheprovider", f"--basetemp={place}"]
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", *quiet, folder],
        cwd=TESTS, env={**os.environ, "LABRUN_WINDOWS_RULES": "1"}, capture_output=True, text=True,
    )  # fmt: skip


@pytest.mark.soak
@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_of_the_suite_holds_under_windows_rules(folder, tmp_path_factory):
    ran = under_the_rules(folder, tmp_path_factory.mktemp("rules"))

    assert ran.returncode == 0, ran.stdout[-5000:] + ran.stderr[-5000:]


@pytest.mark.soak
def test_the_whole_suite_can_be_collected_where_the_tests_have_no_posix_either():
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--collect-only", "-p", "no:xdist", "-p", "no:cacheprovider"],
        cwd=TESTS, env={**os.environ, "LABRUN_WINDOWS_RULES": "all"}, capture_output=True, text=True,
    )  # fmt: skip

    assert ran.returncode == 0, ran.stdout[-5000:] + ran.stderr[-5000:]
