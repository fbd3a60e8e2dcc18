"""What `labrun new device` writes runs, serves and keeps its contract without an edit."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from labrun.drivers.find import check_driver, find_driver
from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.make import device_name, new_device, speaking_device
from labrun.engine.new.protocol import CannotMake
from labrun.schemas.contracts import read_contract, shipped_contracts

SHIPPED = sorted(shipped_contracts())
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}


def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", *words], cwd=folder, capture_output=True, text=True,
        env=ENVIRONMENT,
    )  # fmt: skip


def labrun(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return run(folder, "labrun.engine", *words)


def new(folder: Path, name: str, *options: str) -> subprocess.CompletedProcess[str]:
    done = labrun(folder, "new", "device", name, *options)
    assert done.returncode == 0, done.stderr
    return done


def test_three_files_and_a_lab_are_written_and_what_comes_next_is_said(tmp_path):
    done = new(tmp_path, "hot_plate")
    lab, problems = load_lab(tmp_path / "lab.yaml")
    lines = [line for path in tmp_path.iterdir() for line in path.read_text("utf-8").splitlines()]

    assert {path.name for path in tmp_path.iterdir()} == {
        "hot_plate.py", "hot_plate.yaml", "lab.yaml", "test_hot_plate.py",
    }  # fmt: skip
    assert len(lines) < 120
    assert "pytest test_hot_plate.py" in done.stdout
    assert "labrun serve lab.yaml hot_plate" in done.stdout
    assert problems == []
    assert lab is not None and lab.lab.devices["hot_plate"].contract == "hot_plate@1"


@pytest.mark.parametrize("language", ["scpi", "lines"])
def test_a_device_that_speaks_needs_no_python(tmp_path, language):
    new(tmp_path, "hot_plate", "--speaks", language)
    lab, problems = load_lab(tmp_path / "lab.yaml")
    effects = {n: a.effect for n, a in lab.contracts["hot_plate@1"].actions.items()}
    lines = [line for path in tmp_path.iterdir() for line in path.read_text("utf-8").splitlines()]

    assert problems == []
    assert effects == {
        "read_level": "pure", "shots": "pure", "set_level": "idempotent", "off": "idempotent",
        "fire": "once", "last_once": "pure",
    }  # fmt: skip
    assert {path.name for path in tmp_path.iterdir()} == {"lab.yaml", "test_hot_plate.py"}
    assert len(lines) < 120


@pytest.mark.parametrize("contract", ["own", *SHIPPED])
def test_what_is_written_is_clean_and_keeps_the_shape_of_its_contract(tmp_path, contract):
    new(tmp_path, "hot_plate", *([] if contract == "own" else ["--contract", contract]))
    shape = shipped_contracts().get(contract) or read_contract(tmp_path / "hot_plate.yaml")
    lines = [line for path in tmp_path.iterdir() for line in path.read_text("utf-8").splitlines()]
    ruff = run(tmp_path, "ruff", "check", "--isolated", "--select", "E,F,W,B,UP,SIM", "--ignore",
               "E501", ".")  # fmt: skip

    assert ruff.returncode == 0, ruff.stdout
    assert len(lines) < 120
    for place in ("./hot_plate.py:HotPlate", "./hot_plate.py:SimHotPlate"):
        check_driver(find_driver(place, tmp_path), shape)


@pytest.mark.soak
@pytest.mark.timeout(1000)
@pytest.mark.posix("Windows has no pseudo-terminals")
@pytest.mark.parametrize(
    "contract", ["own", *(pytest.param(one, marks=pytest.mark.soak) for one in SHIPPED)]
)
def test_its_whole_test_passes_for_every_contract(tmp_path, contract):
    new(tmp_path, "hot_plate", *([] if contract == "own" else ["--contract", contract]))
    done = run(tmp_path, "pytest", "-q", "-p", "no:cacheprovider", "test_hot_plate.py")

    assert done.returncode == 0, done.stdout


@pytest.mark.slow
@pytest.mark.posix("Windows ends a process without asking it")
def test_it_serves_and_answers_at_once(tmp_path):
    new(tmp_path, "hot_plate")
    lab = tmp_path / "lab.yaml"
    lab.write_text(lab.read_text().replace("clock: real", "clock: fast"))
    command = [sys.executable, "-m", "labrun.engine", "serve", "lab.yaml", "--port", "0"]
    with subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, text=True, env=ENVIRONMENT
    ) as serving:
        assert serving.stdout is not None
        said = serving.stdout.readline()
        serving.send_signal(signal.SIGINT)
        ended = serving.wait(30)
    called = labrun(tmp_path, "call", "hot_plate.set_level", "level=40", "--lab", "lab.yaml")

    assert said.startswith("hot_plate at http://127.0.0.1:")
    assert ended == 0
    assert called.returncode == 0 and '"level": 40' in called.stdout


@pytest.mark.slow
def test_a_driver_whose_instrument_is_not_there_says_so(tmp_path):
    new(tmp_path, "hot_plate")
    lab = tmp_path / "lab.yaml"
    text = lab.read_text().replace("./hot_plate.py:SimHotPlate", "./hot_plate.py:HotPlate")
    lab.write_text(text.replace("USB0", "Nowhere").replace(", clock: real", ""))
    done = labrun(tmp_path, "serve", "lab.yaml")

    assert done.returncode == 4
    assert "device hot_plate cannot be opened: there is no port /dev/ttyNowhere" in done.stderr


def test_a_lab_that_is_there_is_left_alone_and_its_new_lines_are_told(tmp_path):
    (tmp_path / "lab.yaml").write_text("mine")
    done = new(tmp_path, "hot_plate")

    assert (tmp_path / "lab.yaml").read_text() == "mine"
    assert "driver: ./hot_plate.py:SimHotPlate" in done.stdout
    assert "contracts: [./hot_plate.yaml]" in done.stdout


def test_a_contract_of_ones_own_is_taken_as_it_is(tmp_path):
    new(tmp_path, "first")
    (tmp_path / "lab.yaml").unlink()
    new(tmp_path, "second", "--contract", "./first.yaml")
    lab, problems = load_lab(tmp_path / "lab.yaml")

    assert problems == []
    assert lab is not None and lab.lab.devices["second"].contract == "first@1"
    assert not (tmp_path / "second.yaml").exists()


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "test_hot_plate.py").write_text("mine")
    done = labrun(tmp_path, "new", "device", "hot_plate")

    assert done.returncode == 2 and "test_hot_plate.py already exists" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["test_hot_plate.py"]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Hot-Plate", "'hot_plate' would do"), ("2plates", "is not a valid device name"),
        ("class", "is a Python keyword"), ("json", "already a Python module 'json'"),
        ("com1", "cannot be a file or folder on Windows"),
        ("labrun", "already a Python module 'labrun'"), ("../x", "is not a valid"), ("", "is not a valid"),
    ],
)  # fmt: skip
def test_a_name_that_will_not_do_is_refused_with_a_sentence(name, words):
    with pytest.raises(CannotMake, match=words):
        device_name(name, as_module=True)


def test_only_what_is_written_in_python_needs_the_name_of_a_module(tmp_path, monkeypatch):
    (tmp_path / "dev").mkdir()  # a folder that Python could import from hides nothing
    monkeypatch.syspath_prepend(tmp_path)

    assert device_name("json") == "json"
    assert device_name("dev", as_module=True) == "dev"


@pytest.mark.parametrize(
    ("contract", "words"),
    [
        (None, "there is already a contract gantry@1: use it with --contract gantry@1"),
        ("gantri@1", "did you mean gantry@1"),
        ("./none.yaml", "cannot be read"),
    ],
)
def test_a_contract_that_will_not_do_is_refused_with_a_sentence(contract, words):
    with pytest.raises(CannotMake) as refused:
        new_device("gantry", contract, with_lab=True)

    assert words in str(refused.value)


@pytest.mark.parametrize("language", ["scpi", "lines"])
@pytest.mark.parametrize("contract", SHIPPED)
def test_a_contract_is_kept_by_a_lab_entry_alone(tmp_path, language, contract):
    if any(action.path_params()[0] for action in shipped_contracts()[contract].actions.values()):
        with pytest.raises(CannotMake, match="sends a file, which no line says"):
            speaking_device("hot_plate", language, contract)
        return
    entry, _ = speaking_device("hot_plate", language, contract)
    (tmp_path / "lab.yaml").write_text(f"devices:\n{entry}", "utf-8")
    lab, problems = load_lab(tmp_path / "lab.yaml")

    assert problems == []
    assert lab is not None and lab.lab.devices["hot_plate"].contract == contract
    assert len(entry.splitlines()) < 40


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("device", "x", "--template", "single"), "a device takes --contract"),
        (("device", "plate", "--speaks", "latin"), "a device speaks scpi or lines"),
        (("scan", "--contract", "gantry@1"), "labrun new device scan"),
        (("scan", "--from", "pymeasure:a.B"), "--from is for devices: labrun new device scan"),
        (("device", "x", "--from", "a:B", "--contract", "gantry@1"), "leave out --contract"),
        (("device", "x", "--from", "modbus"), "says no instrument: write, for example, modbus:"),
        (("device",), "which device? labrun new device kiln"),
        (("my", "scan"), "give one name; a name with spaces in quotes: 'my scan'"),
    ],
)
def test_options_that_do_not_belong_are_refused(tmp_path, words, said):
    done = labrun(tmp_path, "new", *words)

    assert done.returncode == 2
    assert said in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_protocol_may_still_be_called_device(tmp_path):
    done = labrun(tmp_path, "new", "device", "--template", "minimal")

    assert done.returncode == 0
    assert (tmp_path / "device.yaml").exists()
