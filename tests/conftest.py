"""For every test: fixed seeds, and what a test needs of the machine beside Python and pip.

Hypothesis draws the same examples in every run; `pytest --hypothesis-profile=explore` draws new
ones, to look for what nobody has thought of yet. A test that needs a screen, Node or
Graphviz bears the marker `needs`. Where that is missing, the test is left out, and one line at
the end says what would bring it. With LABRUN_TEST_EVERYTHING set, as in CI, nothing may be missing.

With LABRUN_WINDOWS_RULES set, labrun meets Windows' rules (`windows/rules`) in every test, and in
every process that one starts; with `all` the tests meet them, too, which can only be collected then.

Python's collector rests until all tests are known, and then never looks at them again: that took a
seventh of the time of pytest's own collection.

Compiled modules are kept beside their sources, whatever PYTHONDONTWRITEBYTECODE says; and Ctrl-C reaches what
the tests start, although a shell that starts the suite in the background has it ignored.
"""

import gc
import importlib
import os
import shutil
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from ctypes.util import find_library
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import settings
from hypothesis.internal.conjecture import providers

from .python_with_tk import python_with_tk

settings.register_profile("fixed", derandomize=True, deadline=None)
settings.register_profile("explore", derandomize=False, deadline=None, max_examples=1000)
settings.load_profile("fixed")
# It would read every source for constants to draw, 3 s in each process, and draw anew when one changes.
providers._get_local_constants = lambda: providers._local_constants

gc.disable()

BY_TERMINALS = (
    "drivers/grbl", "drivers/marlin", "drivers/openbuilds", "drivers/zaber",
    "drivers/balance/test_driver.py", "drivers/window_program/test_record_asked.py",
    "drivers/window_program/test_record_program.py",
    "engine/commands/test_setup_gantry.py", "engine/commands/test_terminal_journeys.py",
    "engine/progress/test_rich_terminal.py", "web/agents/test_mcp.py",
)  # fmt: skip
BY_FORKS = "engine/crashes", "engine/semantics"
"""Of the tests: what is played by pseudo-terminals, and what forks; Windows has neither."""
RULES = Path(__file__).parent / "windows" / "rules"
ON_WINDOWS = sys.platform == "win32" or bool(os.environ.get("LABRUN_WINDOWS_RULES"))
WITHOUT_POSIX = sys.platform == "win32" or os.environ.get("LABRUN_WINDOWS_RULES") == "all"
collect_ignore = [*BY_TERMINALS, *BY_FORKS] if WITHOUT_POSIX else []
if os.environ.get("LABRUN_WINDOWS_RULES"):
    others = [path for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path]
    os.environ["PYTHONPATH"] = os.pathsep.join(dict.fromkeys([str(RULES), *others]))
    if not hasattr(os, "O_BINARY"):  # a worker of pytest-xdist has them from its start
        sys.path.insert(0, str(RULES))
        sys.modules.pop("sitecustomize", None)
        importlib.import_module("sitecustomize")
if WITHOUT_POSIX:
    signal.SIGKILL = signal.SIGTERM  # which ends a process at once there

# The suite starts some thousand processes: each would compile what it imports again.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

STATE = tempfile.mkdtemp(prefix="labrun-state-")
"""In place of the user's own folder for ledgers that outlive a command, for all processes of the tests."""
os.environ["XDG_STATE_HOME"] = STATE


def pytest_unconfigure() -> None:
    """Leave nothing behind."""
    shutil.rmtree(STATE, ignore_errors=True)


class Need(NamedTuple):
    """Something that not every machine has: how to see that it is there, and how to get it."""

    is_there: Callable[[], bool]
    remedy: str


NEEDS = {
    "screen": Need(
        lambda: shutil.which("Xvfb") is not None and python_with_tk() is not None,
        "apt-get install xvfb python3-tk",
    ),
    "node": Need(
        lambda: bool(shutil.which("node") and shutil.which("npm")), "install Node.js 20 or newer"
    ),
    "graphviz": Need(lambda: shutil.which("dot") is not None, "apt-get install graphviz"),
    "libusb": Need(
        lambda: find_spec("pyrealsense2") is not None and find_library("usb-1.0") is not None,
        "apt-get install libusb-1.0-0",
    ),
    "kernel": Need(
        lambda: find_spec("ipykernel") is not None and find_spec("nbclient") is not None,
        "pip install ipykernel nbclient",
    ),
    "pymeasure": Need(
        lambda: find_spec("pymeasure") is not None, "pip install 'labrun[pymeasure]' pyvisa-sim"
    ),
    "qcodes": Need(
        lambda: find_spec("qcodes") is not None, "pip install 'labrun[qcodes]' pyvisa-sim"
    ),
    "ophyd": Need(lambda: find_spec("ophyd") is not None, "pip install 'labrun[ophyd]' caproto"),
    "bluesky": Need(lambda: find_spec("bluesky") is not None, "pip install bluesky"),
    "pylabrobot": Need(
        lambda: find_spec("pylabrobot") is not None, "pip install 'labrun[pylabrobot]'"
    ),
    "sila2": Need(
        lambda: find_spec("sila2") is not None, "pip install 'labrun[sila2]' cryptography"
    ),
    "mcp": Need(lambda: find_spec("mcp") is not None, "pip install 'labrun[mcp]'"),
    "optuna": Need(lambda: find_spec("optuna") is not None, "pip install 'labrun[optuna]'"),
    "zaber": Need(lambda: find_spec("zaber_motion") is not None, "pip install 'labrun[zaber]'"),
    "baybe": Need(lambda: find_spec("baybe") is not None, "pip install 'labrun[baybe]'"),
    "gpcam": Need(lambda: find_spec("gpcam") is not None, "pip install 'labrun[gpcam]'"),
    "asyncua": Need(lambda: find_spec("asyncua") is not None, "pip install 'labrun[opcua]'"),
}
LIBRARIES = {
    "pymeasure",
    "qcodes",
    "ophyd",
    "pylabrobot",
    "bluesky",
    "sila2",
    "asyncua",
    "mcp",
    "optuna",
    "zaber",
    "gpcam",
    "baybe",
}
"""Of instruments: each is tested in an environment of its own, so that labrun's stays small."""
BY_FIXTURE = {"screen": "screen", "node_modules": "node"}
"""Fixture -> what every test that uses it needs."""

SHARED = "tests/web/server/"
"""A room whose files share servers: one process of pytest-xdist has all of it, and begins with it."""

left_out: Counter[str] = Counter()


def pytest_itemcollected(item: pytest.Item) -> None:
    """A test bears the marker of what its fixtures need."""
    for fixture in BY_FIXTURE.keys() & set(getattr(item, "fixturenames", ())):
        item.add_marker(pytest.mark.needs(BY_FIXTURE[fixture]))


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what needs something that is not here."""
    if ON_WINDOWS:
        for item in items:
            for mark in item.iter_markers("posix"):
                item.add_marker(pytest.mark.skip(reason=f"not on Windows: {mark.args[0]}"))
    needed = {item: [n for mark in item.iter_markers("needs") for n in mark.args] for item in items}
    missing = {
        item: [n for n in names if not NEEDS[n].is_there()] for item, names in needed.items()
    }
    out = [item for item in items if missing[item]]
    left_out.update(missing[item][0] for item in out)
    if set(left_out) - LIBRARIES and os.environ.get("LABRUN_TEST_EVERYTHING"):
        raise pytest.UsageError("; ".join(summary(left_out)))
    items[:] = [item for item in items if not missing[item]]
    items.sort(key=lambda item: one_process(item.nodeid) != SHARED)
    config.hook.pytest_deselected(items=out)
    if hasattr(config, "workeroutput"):
        config.workeroutput["left_out"] = dict(left_out)


def pytest_collection_finish() -> None:
    """Collect from here on what tests leave, not what they are."""
    gc.enable()
    gc.freeze()


def one_process(nodeid: str) -> str:
    """What one process does alone, so that what its tests share is made once: a file, or a room."""
    return SHARED if nodeid.startswith(SHARED) else nodeid.split("::", 1)[0]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """Work is handed out by files, in the order of collection."""
    from xdist.scheduler import LoadScopeScheduling

    class ByRoom(LoadScopeScheduling):
        _split_scope = staticmethod(one_process)

    config.option.loadscopereorder = False
    return ByRoom(config, log)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: object) -> None:
    """Hear from a worker of pytest-xdist what it left out: each has collected everything."""
    left_out.update(Counter(getattr(node, "workeroutput", {}).get("left_out", {})) - left_out)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """One line for each thing that was missing."""
    for line in summary(left_out):
        terminalreporter.write_line(line)


def summary(counts: Counter[str]) -> list[str]:
    """What was left out and what would bring it, a line each."""
    return [
        f"{count} tests left out, since they need {name}: {NEEDS[name].remedy}"
        for name, count in sorted(counts.items())
    ]


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Callable[..., object]]:
    """`terminal("run", "scan.yaml")`: a labrun command at a terminal, ended with the test."""
    from .terminal import Terminal  # not on Windows

    made: list[Terminal] = []

    def start(*words: object, **environment: str) -> Terminal:
        made.append(Terminal(tmp_path, *words, **environment))
        return made[-1]

    yield start
    for one in made:
        one.close()
