"""A device whose server runs in an environment of its own."""

import asyncio
import json
import re
import subprocess
import sys
import sysconfig

import pytest

from labrun import __version__
from labrun.drivers.client.launch import ServerFailed, start_server
from labrun.engine.dispatch.connect import server_config
from labrun.engine.lab.lab import load_lab

DRIVER = """
import only_here
from labrun.drivers.driver import Driver


class Where(Driver):
    contract = "where@1"

    async def ask(self, goal):
        return {"prefix": only_here.PREFIX}

    async def status(self):
        return {"prefix": only_here.PREFIX}
"""
CONTRACT = "type: where@1\nactions: {ask: {effect: pure, returns: {properties: {prefix: {type: string}}}}}\n"
LAB = """contracts: [./where.yaml]
devices:
  there: {contract: where@1, driver: "./where.py:Where", python: ENV/bin/python}
"""


@pytest.fixture
def lab(tmp_path):
    """A lab beside a virtual environment with a module that no other one has."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "env"], check=True)
    (packages,) = (tmp_path / "env").glob("lib/python*/site-packages")
    (packages / "only_here.py").write_text("import sys\nPREFIX = sys.prefix\n")
    (tmp_path / "where.py").write_text(DRIVER)
    (tmp_path / "where.yaml").write_text(CONTRACT)
    (tmp_path / "lab.yaml").write_text(LAB.replace("ENV", "./env"))

    def with_labrun():
        ours = sysconfig.get_paths()["purelib"]
        (packages / "labrun.pth").write_text(f"import site; site.addsitedir({ours!r})\n")

    return tmp_path, with_labrun


def config(folder):
    loaded, problems = load_lab(folder / "lab.yaml")
    assert problems == []
    return server_config(loaded.lab.devices, loaded, folder / "servers")


def test_its_server_runs_in_its_own_environment(lab):
    folder, with_labrun = lab
    with_labrun()

    async def story():
        server = await start_server(config(folder), folder / "servers" / "there")
        try:
            from labrun.drivers.client.client import DeviceClient

            client = DeviceClient(server.url)
            await client.open()
            told = client.devices["there"].status
            await client.close()
            return told
        finally:
            await server.stop()

    assert asyncio.run(story()) == {"prefix": str(folder / "env")}


def test_an_environment_without_labrun_or_without_python_is_named(lab):
    folder, _ = lab
    with pytest.raises(
        ServerFailed, match=r"its environment needs labrun, too: `.*-m pip install labrun`"
    ):
        asyncio.run(start_server(config(folder), folder / "servers" / "there"))
    (folder / "lab.yaml").write_text(LAB.replace("ENV", "./nowhere"))
    with pytest.raises(ServerFailed, match=r"nowhere/bin/python`.*\(No such file or directory\)"):
        asyncio.run(start_server(config(folder), folder / "servers" / "other"))


@pytest.mark.posix("a shell script is no program there")
@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ("echo hello", r"`, which the lab names, is no Python"),
        ("echo python 3 9 0.1.0", r"is Python 3\.9, and labrun needs 3\.11"),
        (
            """echo python 3 12 -;; *) echo '{"ready": false, "error": "no cable"}'; exit 4""",
            "did not start: no cable",  # from a server, so that labrun is there
        ),
        ("echo python 3 12 0.0.9", rf"has labrun 0\.0\.9, and this is {re.escape(__version__)}"),
    ],
)
def test_another_python_or_another_labrun_is_named(lab, answer, words):
    folder, _ = lab
    script = folder / "odd" / "bin" / "python"
    script.parent.mkdir(parents=True)
    script.write_text(f"#!/bin/sh\ncase $1 in -c) {answer};; *) exit 2;; esac\n")
    script.chmod(0o755)
    (folder / "lab.yaml").write_text(LAB.replace("ENV", "./odd"))
    with pytest.raises(ServerFailed, match=words):
        asyncio.run(start_server(config(folder), folder / "servers" / "there"))


def test_python_is_for_a_driver(tmp_path):
    (tmp_path / "lab.yaml").write_text(
        json.dumps({"devices": {"g": {"contract": "gantry@1", "url": "http://a:1", "python": "p"}}})
    )
    _, problems = load_lab(tmp_path / "lab.yaml")

    assert "`python` starts the server of a `driver`" in problems[0].message
