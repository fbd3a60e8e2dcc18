"""One endpoint for the tests that only ask; the stock clients that ask it."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from .served import serve

HERE = Path(__file__).parent
CLIENTS = HERE / "clients"
TALK_S = 90


@pytest.fixture(scope="session")
def lab(tmp_path_factory):
    """A lab in a folder of its own, with its contract and its driver."""
    folder = tmp_path_factory.mktemp("lab")
    for name in ("lab.yaml", "lamp.yaml", "lamp.py"):
        shutil.copy(HERE / name, folder)
    return folder / "lab.yaml"


@pytest.fixture(scope="session")
def endpoint(lab, tmp_path_factory):
    served = serve(tmp_path_factory.mktemp("endpoint"), lab=lab)
    yield served

    assert served.end() == 0
    assert "Traceback" not in (served.folder / "ros.log").read_text()


@pytest.fixture(scope="session")
def node_modules():
    """roslib 2 and roslib 1.4 as npm has them, kept from one session to the next."""
    if shutil.which("npm") is None or shutil.which("node") is None:
        pytest.skip("node and npm are not there: stock roslib cannot be run")
    lock = (CLIENTS / "package-lock.json").read_bytes()
    folder = Path(tempfile.gettempdir()) / f"labrun-roslib-{hashlib.sha256(lock).hexdigest()[:12]}"
    if not (folder / "complete").exists():
        half = Path(tempfile.mkdtemp(prefix="labrun-roslib-"))
        for name in ("package.json", "package-lock.json"):
            shutil.copy(CLIENTS / name, half)
        subprocess.run(
            ["npm", "ci", "--no-audit", "--no-fund"], cwd=half, check=True, capture_output=True
        )
        (half / "complete").touch()
        shutil.rmtree(folder, ignore_errors=True)
        half.rename(folder)
    return folder


def _talk(command, url, steps):
    done = subprocess.run(
        [*command, url, json.dumps(steps)], capture_output=True, text=True, timeout=TALK_S,
        env={**os.environ, "PYTHONWARNINGS": "ignore"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.fixture
def roslibpy():
    command = [sys.executable, str(CLIENTS / "roslibpy_talk.py")]
    return lambda url, *steps: _talk(command, url, steps)


def _node(node_modules, name):
    # A script finds its modules beside itself, so it is run from where they are.
    shutil.copy(CLIENTS / name, node_modules / name)
    return lambda url, *steps: _talk(["node", str(node_modules / name)], url, steps)


@pytest.fixture
def roslib2(node_modules):
    return _node(node_modules, "roslib2_talk.mjs")


@pytest.fixture
def roslib1(node_modules):
    return _node(node_modules, "roslib1_talk.cjs")


@pytest.fixture(params=["roslibpy", "roslib2", "roslib1"])
def talk(request):
    """Each of the stock clients in turn: `talk(url, step, ...)` gives what came of the steps."""
    return request.getfixturevalue(request.param)
