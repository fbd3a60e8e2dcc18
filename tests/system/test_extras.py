"""Whatever is not installed is said in one line that adds it; the base does the rest without it."""

import ast
import json
import os
import re
import subprocess
import sys
import tomllib
from contextlib import nullcontext
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from labrun.drivers.find import DriverFault, check_installed, find_driver
from labrun.drivers.server.execution import fault_of
from labrun.engine.cli import COMMANDS, FROM_ENTRY_POINTS
from labrun.engine.commands.check_files import check_files
from labrun.engine.export.formats import OWN
from labrun.engine.lab.lab import load_lab
from labrun.system.extras import EXTRAS, OF_DRIVERS, in_words, line, missing, not_installed
from labrun.web.local.refusal import as_response

ROOT = Path(__file__).parents[2]
FOLDERS = ("drivers", "engine", "reduction", "schemas", "system", "web")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EVERY = sorted({library for libraries in EXTRAS.values() for library in libraries})
BY_THE_SYSTEM = {
    "rclpy",
    "rosidl_runtime_py",
    "diagnostic_msgs",
    "action_msgs",
    "unique_identifier_msgs",
}
THROUGH_ANOTHER = {"starlette", "distributed", "pydantic_core", "torch"}
"""Come with fastapi, as `dask[distributed]`, with pydantic (it wants just one version), and with BayBE."""
BY_HAND = {"apsw", "libskit", "setuptools"}
"""For simulated disks, a script that compiles the table of lines, and the installation."""


def without(*libraries: str) -> dict[str, str]:
    """The environment of a process in which these cannot be imported."""
    paths = [str(Path(__file__).parent / "without"), os.environ.get("PYTHONPATH", "")]
    return {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, paths)),
        "LABRUN_TEST_WITHOUT": " ".join(libraries or EVERY),
    }


def labrun(folder: Path, *words: object, env: dict[str, str]) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-m", "labrun.engine", *map(str, words)],
        cwd=folder, env=env, capture_output=True, encoding="utf-8",
    )  # fmt: skip


def python(program: str, *libraries: str) -> str:
    """What a program prints where these libraries are missing."""
    ran = subprocess.run(
        [sys.executable, "-c", program],
        env=without(*libraries),
        capture_output=True,
        encoding="utf-8",
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def name_of(requirement: str) -> str:
    """The project that a requirement is for, written in the one way."""
    found = re.match(r"[\w.-]+", requirement)
    assert found is not None
    return re.sub(r"[-_.]+", "-", found[0]).lower()


def required(extra: str) -> set[str]:
    """The projects that an extra asks for, with those of the extras in it."""
    names = set()
    for requirement in PROJECT["optional-dependencies"][extra]:
        inner = re.match(r"labrun\[([\w,]+)\]", requirement)
        names |= (
            {n for e in inner[1].split(",") for n in required(e)}
            if inner
            else {name_of(requirement)}
        )
    return names


installed = cache(packages_distributions)


def projects(library: str) -> set[str]:
    """The installed projects that bring a library."""
    return {name_of(project) for project in installed().get(library, [])}


def imports() -> dict[str, set[str]]:
    """Library -> the files that import it, wherever in them."""
    found: dict[str, set[str]] = {}
    for path in (p for folder in FOLDERS for p in (ROOT / folder).rglob("*.py")):
        if "node_modules" in path.parts:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            named = [n.name for n in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level and node.module:
                named = [node.module]
            for name in named:
                found.setdefault(name.partition(".")[0], set()).add(str(path.relative_to(ROOT)))
    return found


def test_every_extra_that_brings_a_library_of_labrun_is_known():
    assert EXTRAS.keys() == PROJECT["optional-dependencies"].keys() - {"all", "docs", "test"}


IN_ENVIRONMENTS_OF_THEIR_OWN = {
    "pymeasure",
    "qcodes",
    "ophyd",
    "pylabrobot",
    "sila2",
    "opcua",
    "mcp",
    "optuna",
    "oak",
    "zaber",
    "gpcam",
    "baybe",
}


@pytest.mark.parametrize("extra", sorted(EXTRAS.keys() - IN_ENVIRONMENTS_OF_THEIR_OWN))
def test_an_extra_brings_the_libraries_that_it_is_said_to_bring(extra):
    brought = {
        library: projects(library) for library in EXTRAS[extra] if library not in THROUGH_ANOTHER
    }

    assert [library for library, by in brought.items() if not by & required(extra)] == []


@pytest.mark.slow
def test_every_library_that_labrun_imports_is_in_the_base_or_in_an_extra():
    base = {name_of(requirement) for requirement in PROJECT["dependencies"]}
    others = {
        library: files
        for library, files in imports().items()
        if library
        not in {
            *sys.stdlib_module_names,
            "labrun",
            *EVERY,
            *BY_THE_SYSTEM,
            *THROUGH_ANOTHER,
            *BY_HAND,
        }
        and library not in ("Xlib", "comtypes", "pywinauto")  # of `gui`, on Linux and on Windows
        and not projects(library) & base
    }

    assert others == {}


def test_all_brings_neither_bridges_nor_what_works_the_screen():
    bridges = required("visa") | required("modbus") | required("ros") | {"pyautogui"}

    assert not required("all") & bridges


@pytest.fixture
def files(tmp_path):
    """A protocol, a spectrum and a table in a folder."""
    (tmp_path / "one.yaml").write_text(
        "labrun: 1\nname: one\ndevices: {gantry: gantry@1}\n"
        "steps: [{do: gantry.move_to, with: {x: 1 mm, y: 1 mm}}]\n"
    )
    rows = "\n".join(f"{200 + n / 5:.1f},{100 + n % 7}" for n in range(2000))
    (tmp_path / "shot.csv").write_text(f"wavelength,intensity\n{rows}\n")
    matrix = [[500, 0, 320], [0, 500, 240], [0, 0, 1]]
    camera = {"width": 640, "height": 480, "matrix": matrix, "distortion": [0] * 5}
    (tmp_path / "camera.yaml").write_text(json.dumps(camera))
    (tmp_path / "data.csv").write_text(
        "x,y,Li\n" + "\n".join(f"{n % 3},{n // 3},{n}" for n in range(9))
    )
    return tmp_path


LACKING = {
    "preview": ("preview one.yaml", "spectra"),
    "reduce": ("reduce shot.csv -o tables", "spectra"),
    "spectrum": ("spectrum shot.csv -o figures", "spectra"),
    "map": ("map .", "spectra"),
    "mcp": ("mcp .", "mcp"),
    "web": ("web --no-browser --port 0", "web"),
    "calibrate-camera": ("calibrate-camera shot.csv --board 9x6 --square 10", "vision"),
    "locate": ("locate --image shot.csv --camera camera.yaml --pixel 1,1", "vision"),
    "find-buttons": ("find-buttons . --image shot.csv", "gui"),
    "lines": ("lines Li", "numpy"),
    "calibrate": ("calibrate response shot.csv", "spectra"),
    "record-program": ("record-program --find -o . --image shot.csv", "gui"),
    "record-buttons": ("record-buttons --image shot.csv -o buttons", "gui"),
}
"""Command -> words that need its extra."""
WITHOUT_ANY = {
    "abort", "answer", "call", "change", "check", "compare", "continue", "devices", "docs", "explain",
    "fmt", "graph", "label", "new", "pause", "problem", "rehearse", "release", "report", "resume",
    "ros", "run", "runs", "schema", "serve", "setup", "status", "stop", "torture", "words",
}  # fmt: skip
BY_ITS_OPTION = {"export"}


@pytest.mark.parametrize("name", OWN)
def test_a_format_without_its_extra_says_the_line_that_adds_it(name):
    program = (
        "from labrun.engine.export.formats import ExportFault, formats\n"
        f"try:\n    formats()['{name}']()\nexcept ExportFault as fault:\n    print(fault)\n"
    )

    assert python(program).strip().endswith('-m pip install "labrun[export]"')


def test_every_command_is_walked_here():
    assert LACKING.keys() | WITHOUT_ANY | BY_ITS_OPTION == {*COMMANDS, *FROM_ENTRY_POINTS}


@pytest.mark.parametrize("command", LACKING)
def test_a_command_without_its_extra_says_the_line_that_adds_it(files, command):
    words, extra = LACKING[command]
    ran = labrun(files, *words.split(), env=without())

    assert ran.returncode == 2
    assert ran.stderr.strip().count("\n") == 0
    assert ran.stderr.startswith((f"labrun {command}: ", "labrun: "))
    advice = rf'is not installed; add it with: \S*python\S* -m pip install "labrun\[{extra}\]"$'
    assert re.search(advice, ran.stderr.strip())


def test_every_command_can_be_asked_for_help_without_any_extra():
    program = (
        "import sys\nfrom labrun.engine.cli import COMMANDS, FROM_ENTRY_POINTS, main\n"
        "for command in [*COMMANDS, *FROM_ENTRY_POINTS]:\n"
        "    sys.argv = ['labrun', command, '--help']\n"
        "    try:\n        main()\n"
        "    except SystemExit as end:\n        print('helped', command, end.code or 0)\n"
    )
    helped = re.findall(r"^helped (\S+) 0$", python(program), re.MULTILINE)

    assert sorted(helped) == sorted({*COMMANDS, *FROM_ENTRY_POINTS})


def test_every_driver_is_there_or_says_the_line_that_adds_what_it_needs():
    program = (
        "import json\nfrom pathlib import Path\n"
        "from labrun.drivers.find import SHIPPED, DriverFault, check_installed, find_driver\n"
        "said = {}\nfor name in SHIPPED:\n"
        "    try:\n        check_installed(find_driver(name, Path()), {})\n"
        "    except DriverFault as fault:\n        said[name] = str(fault)\n"
        "print(json.dumps(said))"
    )
    said = json.loads(python(program))
    extras = {name: re.search(r"labrun\[(\w+)\]", words) for name, words in said.items()}

    assert {name: found and found[1] for name, found in extras.items()} == OF_DRIVERS
    assert {*OF_DRIVERS.values()} <= EXTRAS.keys()


@pytest.mark.parametrize(
    ("library", "said", "why"),
    [
        (
            "cv2",
            "libGL.so.1: cannot open shared object file",
            "; add it with: apt-get install libgl1",
        ),
        (
            "cv2",
            "DLL load failed while importing cv2",
            "; add it with: Microsoft's Visual C++ Redis",
        ),
        ("h5py", "cannot import name 'z' from 'h5py'", "cannot import name 'z' from 'h5py'"),
    ],
)
def test_a_library_that_is_there_and_cannot_be_loaded_says_what_the_system_lacks(
    library, said, why
):
    told = not_installed(ImportError(said, name=library)) or ""

    assert told.startswith(f"{library} is installed, but cannot be loaded: {said}")
    assert why in told
    assert "pip install" not in told
    assert in_words(ImportError(said, name=library)) == told


def test_a_fault_that_is_not_a_library_s_is_told_by_its_kind():
    assert in_words(ImportError("libfoo.so is missing")) == "ImportError: libfoo.so is missing"
    assert in_words(ValueError("x")) == "ValueError: x"


def test_an_action_whose_driver_lacks_a_library_says_what_adds_it():
    ending = fault_of("camera.capture", ModuleNotFoundError("no", name="cv2"))

    assert ending.error is not None
    assert "cv2 is not installed; add it with: " in ending.error.message


def test_a_fault_that_no_extra_would_cure_is_left_as_it_is():
    assert not_installed(ModuleNotFoundError("no", name="labrun.nowhere")) is None
    assert not_installed(ImportError("libfoo.so is missing")) is None


def test_what_is_there_is_not_missing(monkeypatch):
    assert missing("web") is None
    monkeypatch.setitem(sys.modules, "starlette", None)
    monkeypatch.setitem(EXTRAS, "web", ("fastapi", "no_such_library"))

    assert "no_such_library is not installed" in (missing("web") or "")


def test_the_page_is_told_as_a_refusal():
    answer = as_response(ModuleNotFoundError("no", name="scipy.special"))

    assert answer.status_code == 501
    assert "labrun[spectra]" in json.loads(bytes(answer.body))["message"]


def test_the_line_can_be_given_from_the_folder_where_python_lies(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "my lab" / "bin" / "python"))

    assert line("web") == f'"{Path("my lab/bin/python")}" -m pip install "labrun[web]"'


@pytest.mark.slow
def test_a_run_needs_no_extra(tmp_path):
    ran = labrun(tmp_path, "run", ROOT / "protocols" / "hello.yaml", env=without())

    assert "run succeeded" in ran.stdout + ran.stderr
    assert "not installed" not in ran.stdout + ran.stderr


@pytest.mark.slow
def test_a_run_that_needs_more_says_so_before_anything_is_sent(tmp_path):
    ran = labrun(tmp_path, "run", ROOT / "protocols" / "pegmatite_map.yaml", env=without())

    assert ran.returncode == 4
    assert "labrun[spectra]" in ran.stderr
    assert "Nothing was sent." in ran.stderr


@pytest.mark.parametrize("driver", sorted(OF_DRIVERS))
def test_a_check_says_what_the_driver_of_a_device_lacks(driver, files, capsys, monkeypatch):
    for library in EXTRAS[OF_DRIVERS[driver]]:
        monkeypatch.setitem(sys.modules, library, None)
    (files / "lab.yaml").write_text(
        f"name: bench\ndevices: {{gantry: {{contract: gantry@1, driver: {driver}}}}}\n"
    )
    status = check_files([files / "one.yaml"], lab=files / "lab.yaml")
    *problems, told = capsys.readouterr().out.splitlines()

    without_config = any("error[E132] config" in line for line in problems)
    assert status == (2 if without_config else 0)
    assert without_config or problems[-1].endswith("no problems.")
    assert told.startswith("To run it from here: gantry cannot work, since ")
    assert told.endswith(f'"labrun[{OF_DRIVERS[driver]}]"')


@pytest.mark.parametrize(
    ("device", "wanted"),
    [
        ("driver: scpi, config: {resource: 'GPIB0::22::INSTR', ACTIONS}", "pyvisa"),
        ("driver: scpi, config: {resource: 'TCPIP::10.0.0.5::5025::SOCKET', ACTIONS}", ""),
        ("driver: pymeasure, config: {instrument: keithley.Keithley2000, resource: x, GET}", "pymeasure"),
        ("driver: qcodes, python: ../their/python, config: {instrument: Keithley.K2450, GET}", ""),
        ("driver: ophyd, config: {instrument: sim.SynAxis, GET}", "ophyd"),
        ("driver: ophyd, config: {instrument: ophyd_async.sim.SimMotor, GET}", "ophyd_async"),
        ("driver: ophyd, config: {instrument: decimal.Decimal, GET}", ""),
    ],
)  # fmt: skip
def test_what_a_bridge_lacks_depends_on_its_instrument(device, wanted, tmp_path, monkeypatch):
    for library in {lib for extra in OF_DRIVERS.values() for lib in EXTRAS[extra]} | {"pyvisa"}:
        monkeypatch.setitem(sys.modules, library, None)
    told = "returns: {v: {unit: V}}}}"
    said = device.replace("ACTIONS", f"actions: {{volts: {{query: 'V?', {told}")
    said = said.replace("GET", f"actions: {{volts: {{get: volts, {told}")
    (tmp_path / "lab.yaml").write_text(f"name: b\ndevices:\n  dmm: {{contract: dmm@1, {said}}}\n")
    lab, problems = load_lab(tmp_path / "lab.yaml")
    assert lab is not None and problems == []
    lacking = lab.lacking(["dmm"])

    assert list(lacking) == (["dmm"] if wanted else [])
    if wanted:
        assert lacking["dmm"].startswith(f"{wanted} is not installed; add it with: ")
    if lab.lab.devices["dmm"].python is None:  # a device server looks for the same
        name, config = lab.lab.devices["dmm"].driver, lab.lab.devices["dmm"].config
        with pytest.raises(DriverFault, match=wanted) if wanted else nullcontext():
            check_installed(find_driver(name or "", tmp_path), config)


@pytest.mark.slow
def test_a_simulated_shot_without_its_extra_says_so_and_the_rest_of_the_analyser_works(tmp_path):
    (tmp_path / "shot.yaml").write_text(
        "labrun: 1\nname: shot\ndevices: {libs: libs_analyzer@1}\n"
        "steps: [{do: libs.locate}, {do: libs.measure}]\n"
    )
    ran = labrun(tmp_path, "rehearse", "shot.yaml", env=without("numpy"))

    assert ran.returncode == 1
    assert "libs.measure" in ran.stdout + ran.stderr
    assert "labrun[numpy]" in ran.stdout + ran.stderr


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    """Python of an environment into which the base was installed from a wheel, as a person does."""
    folder = tmp_path_factory.mktemp("clean")
    build = [sys.executable, "-m", "build", "-q", "--wheel", "--outdir", folder, ROOT]
    subprocess.run(build, check=True, env={**os.environ, "LABRUN_SKIP_PAGE": "1"})
    subprocess.run([sys.executable, "-m", "venv", folder / "env"], check=True)
    python = next(
        p for p in (folder / "env/bin/python", folder / "env/Scripts/python.exe") if p.exists()
    )
    (wheel,) = folder.glob("*.whl")
    subprocess.run([python, "-m", "pip", "install", "-q", wheel], check=True)
    return python


@pytest.mark.soak
@pytest.mark.parametrize("command", LACKING)
def test_in_a_clean_environment_the_line_that_is_said_brings_what_is_missing(clean, files, command):
    words = [str(clean), "-m", "labrun.engine", *LACKING[command][0].split()]

    def said() -> str:
        try:
            return subprocess.run(
                words, cwd=files, capture_output=True, encoding="utf-8", timeout=30
            ).stderr
        except subprocess.TimeoutExpired:
            return ""  # it serves

    lacking = said()
    # An earlier command may have brought the same extra.
    for _ in range(2):
        if "add it with: " in lacking:
            subprocess.run(
                lacking.partition("add it with: ")[2].strip(), shell=True, check=True, cwd=files
            )
            lacking = said()

    assert "is not installed" not in lacking
    assert "internal error" not in lacking
