"""A start imports what it uses: the version nothing, a check no units, a device server no client."""

import json
import os
import re
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path

import pytest

from labrun.schemas.contracts import shipped_contracts
from labrun.system.start import later, patterns_when_used, without

HEAVY = {
    "aiohttp", "cv2", "dask", "fastapi", "jsonschema", "matplotlib", "numba", "numpy", "pandas",
    "pint", "PIL", "pyarrow", "requests.api", "rich.table", "ruamel", "scipy", "tornado.httputil",
    "importlib.metadata", "email",
}  # fmt: skip
COMMANDS = HEAVY | {"asyncio", "socketio", "uvicorn", "ssl", "py_trees", "labrun.drivers"}
STEP = """labrun: 1
name: one
devices: {gantry: gantry@1}
steps:
  - {do: gantry.move_to, with: {x: 10 mm}, timeout: 2 min}
"""
LABRUN = "from labrun.engine.cli import main; main()"


def imported(said: str) -> set[str]:
    """The modules that `-X importtime` names, each also by every package that it is in."""
    names = re.findall(r"^import time:.*\|\s+([\w.]+)$", said, re.MULTILINE)
    return {name[: at.end()] for name in names for at in re.finditer(r"\w+", name)}


def imported_by(*arguments: str) -> set[str]:
    command = [sys.executable, "-X", "importtime", "-c", LABRUN, *arguments]
    ran = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
    return imported(ran.stderr)


def before_all() -> set[str]:
    """What Python has imported before the program begins, as an editable installation does."""
    command = [sys.executable, "-X", "importtime", "-c", "pass"]
    return imported(subprocess.run(command, capture_output=True, encoding="utf-8").stderr)


def test_the_version_is_said_without_any_library():
    extra = imported_by("--version") - before_all()

    assert extra & (COMMANDS | {"typer", "pydantic", "yaml", "labrun.schemas"}) == set()


def test_a_check_with_usual_units_imports_neither_pint_nor_what_only_runs_need(tmp_path):
    path = tmp_path / "one.yaml"
    path.write_text(STEP, encoding="utf-8")

    assert (imported_by("check", str(path)) - before_all()) & COMMANDS == set()


def test_units_that_need_pint_need_no_numpy(tmp_path):
    path = tmp_path / "one.yaml"
    path.write_text(STEP.replace("10 mm", "0.4 inch"), encoding="utf-8")
    there = imported_by("check", str(path)) - before_all()

    assert there & {"pint", "numpy._core", "dask"} == {"pint"}  # what is not found is named, too


def test_a_check_without_options_imports_nothing_that_reads_options(tmp_path):
    path = tmp_path / "one.yaml"
    path.write_text(STEP, encoding="utf-8")
    rarely = {"typer", "importlib.resources", "hashlib", "statistics"}
    there = imported_by("check", str(path)) - before_all()

    assert "labrun.engine.check" in there
    assert there & rarely == set()


def test_a_device_server_imports_no_client_and_no_library_that_its_driver_does_not_use(tmp_path):
    contract = shipped_contracts()["gantry@1"].model_dump(mode="json")
    device = {"contract": contract, "driver": "sim_gantry", "limits": {"x": {"maximum": "40 cm"}}}
    settings, log = tmp_path / "settings.json", tmp_path / "log"
    settings.write_text(json.dumps({"folder": str(tmp_path / "s"), "devices": {"gantry": device}}))
    command = [sys.executable, "-X", "importtime", "-m", "labrun.drivers.server.serve"]
    with (
        log.open("w") as sink,
        subprocess.Popen([*command, str(settings)], stdout=subprocess.PIPE, stderr=sink) as server,
    ):
        assert server.stdout is not None
        assert json.loads(server.stdout.readline())["ready"]
        server.terminate()

    there = imported(log.read_text())
    assert "socketio.async_server" in there
    # Parts of these are needed by uvicorn and websockets.
    its = {"email", "importlib.metadata"}
    assert (there - before_all()) & (HEAVY - its | {"typer", "labrun.engine"}) == set()


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of its own, whose import writes a file."""
    (tmp_path / "heavy_one.py").write_text(
        "from pathlib import Path\nPath(__file__).with_name('loaded').touch()\n"
        "answer = 42\ndef ask(): return answer\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path / "loaded"
    sys.modules.pop("heavy_one", None)


def test_what_is_imported_later_is_loaded_when_something_in_it_is_asked_for(package: Path):
    with later("heavy_one"):
        import heavy_one  # pyright: ignore

    assert not package.exists()
    assert heavy_one.answer == 42
    assert package.exists()


def test_a_function_of_it_may_be_imported_by_name(package: Path):
    with later("heavy_one", "ask"):
        from heavy_one import ask  # pyright: ignore

    assert not package.exists()
    assert ask() == 42


def test_after_the_block_it_is_imported_as_ever(package: Path):
    with later("heavy_one"):
        pass
    import heavy_one  # pyright: ignore

    assert package.exists()
    assert type(heavy_one).__module__ == "builtins"


def test_a_pattern_is_compiled_when_it_is_first_used():
    with patterns_when_used():
        pattern, broken = re.compile("(A)b", re.IGNORECASE), re.compile("(")

    assert pattern.sub(r"\1", "xab") == "xa"
    assert (pattern.pattern, pattern.groups) == ("(A)b", 1)
    assert isinstance(re.compile("a"), re.Pattern)
    with pytest.raises(re.error):
        broken.match("a")


def test_one_thread_does_without_a_library_and_another_has_it(package: Path):
    found = []
    with without("heavy_one"):
        with pytest.raises(ModuleNotFoundError):
            import_module("heavy_one")
        other = threading.Thread(target=lambda: found.append(import_module("heavy_one").answer))
        other.start()
        other.join()

    assert found == [42]


def test_no_thread_has_a_library_that_is_left_out_everywhere(package: Path):
    with without("heavy_one", everywhere=True), ThreadPoolExecutor(1) as other:
        asked = other.submit(import_module, "heavy_one")

    assert isinstance(asked.exception(), ModuleNotFoundError)


def test_a_server_process_can_still_be_a_client_of_another():
    # engineio has kept the stand-in: the first connection loads what is behind it.
    program = (
        "from labrun.system.start import spare_of_socketio\n"
        "spare_of_socketio('aiohttp')\n"
        "import asyncio, socketio, sys\n"
        "assert 'aiohttp' not in sys.modules\n"
        "async def main():\n"
        "    try:\n        await socketio.AsyncClient().connect('http://127.0.0.1:9', wait_timeout=5)\n"
        "    except socketio.exceptions.ConnectionError as fault: print(fault)\n"
        "asyncio.run(main())\n"
        "assert 'aiohttp' in sys.modules\n"
    )
    ran = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, encoding="utf-8", env={**os.environ}
    )

    assert ran.returncode == 0, ran.stderr
    assert "127.0.0.1" in ran.stdout or "onnect" in ran.stdout
