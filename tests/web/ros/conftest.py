"""One endpoint for the tests that only ask; the stock clients that ask it."""

import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from ...npm import installed
from .served import serve

HERE = Path(__file__).parent
CLIENTS = HERE / "clients"
TALK_S = 500


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
    return installed(CLIENTS, "roslib")


class Talker:
    """A stock client in a process of its own, which is kept: `talk(url, step, ...)` is one connection."""

    def __init__(self, command):
        self._errors = tempfile.TemporaryFile("w+")  # noqa: SIM115 - kept as long as the process
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, text=True,
            env={**os.environ, "PYTHONWARNINGS": "ignore"},
        )  # fmt: skip

    def __call__(self, url, *steps):
        self._process.stdin.write(json.dumps({"url": url, "steps": steps}) + "\n")
        self._process.stdin.flush()
        answered = select.select([self._process.stdout], [], [], TALK_S)[0]
        line = self._process.stdout.readline() if answered else ""
        assert line, self._said()
        return json.loads(line)

    def _said(self):
        self._errors.seek(0)
        return f"{self._process.args} did not answer: {self._errors.read()}"

    def end(self):
        try:
            self._process.communicate()
        except subprocess.TimeoutExpired:  # it waits for an answer that a failed test did not get
            self._process.kill()
            self._process.communicate()
        self._errors.close()


@pytest.fixture(scope="session")
def roslibpy():
    talker = Talker([sys.executable, str(CLIENTS / "roslibpy_talk.py")])
    yield talker
    talker.end()


def _node(node_modules, name):
    # A script finds its modules beside itself, so it is run from where they are.
    script = node_modules / f"{os.getpid()}_{name}"
    shutil.copy(CLIENTS / name, script)
    talker = Talker(["node", str(script)])
    yield talker
    talker.end()
    script.unlink(missing_ok=True)


@pytest.fixture(scope="session")
def roslib2(node_modules):
    yield from _node(node_modules, "roslib2_talk.mjs")


@pytest.fixture(scope="session")
def roslib1(node_modules):
    yield from _node(node_modules, "roslib1_talk.cjs")


@pytest.fixture(
    params=[
        "roslibpy",
        pytest.param("roslib2", marks=pytest.mark.needs("node")),
        pytest.param("roslib1", marks=pytest.mark.needs("node")),
    ]
)
def talk(request):
    """Each of the stock clients in turn: `talk(url, step, ...)` gives what came of the steps."""
    return request.getfixturevalue(request.param)
