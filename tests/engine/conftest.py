"""A real device server with two scripted devices, and a way to run protocols on it."""

import json
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from labrun.engine.check import check_file
from labrun.engine.commands.run import start
from labrun.engine.journal import read_records

LAB = Path(__file__).parent / "lab"
HEADER = "labrun: 1\nname: test\ndevices: {a: scripted@1, b: scripted@1}\n"


@dataclass
class Bench:
    """The scripted devices as they are served, and what they were asked."""

    lab: Path
    world: Path

    def calls(self, run=None):
        log = self.world / "calls.jsonl"
        lines = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
        return [line for line in lines if run is None or line.get("run") == run]


@dataclass
class Ran:
    """A run that is over."""

    status: int
    folder: Path
    bench: Bench

    @property
    def records(self):
        return list(read_records(self.folder / "journal.jsonl"))

    @property
    def finished(self):
        return self.records[-1]

    @property
    def calls(self):
        return self.bench.calls(self.folder.name)

    def sent(self, *words):
        """Names of what devices began to do, in order."""
        return [c["name"] for c in self.calls if c["word"] != "done"]

    def rows(self, name="data.csv"):
        lines = (self.folder / name).read_text().splitlines()
        header = lines[0].split(",")
        return [dict(zip(header, line.split(","), strict=True)) for line in lines[1:]]


@pytest.fixture(scope="session")
def bench(tmp_path_factory):
    """One server for all tests: each run's calls are told apart by the run's name."""
    folder = tmp_path_factory.mktemp("bench")
    contract = YAML(typ="safe").load((LAB / "scripted.yaml").read_text())
    device = {"contract": contract, "driver": f"{LAB / 'scripted.py'}:Scripted", "config": {}}
    config = {
        "devices": {"a": device, "b": device}, "folder": str(folder / "server"),
        "world": str(folder / "world"), "host": "127.0.0.1", "port": 0,
    }  # fmt: skip
    (folder / "config.json").write_text(json.dumps(config))
    process = subprocess.Popen(
        [sys.executable, "-m", "labrun.drivers.serve", str(folder / "config.json")],
        stdout=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    ready = json.loads(process.stdout.readline())
    lab = folder / "lab.yaml"
    lab.write_text(
        f"name: scripted\ncontracts: [{LAB / 'scripted.yaml'}]\ndevices:\n"
        f"  a: {{contract: scripted@1, url: '{ready['url']}'}}\n"
        f"  b: {{contract: scripted@1, url: '{ready['url']}'}}\n"
    )
    yield Bench(lab, folder / "world")
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=20)


@pytest.fixture
def run(bench, tmp_path):
    """Run a protocol from its steps; the answer is what it left behind."""

    def run_steps(body, *, yes=False, answers=None, params=None):
        path = tmp_path / "test.yaml"
        path.write_text(HEADER + body, encoding="utf-8")
        checked = check_file(path, lab=bench.lab, params=params or {})
        assert checked.ok, checked.problems
        status = start(checked, tmp_path / "runs", given=params, yes=yes, answers=answers)
        (folder,) = (tmp_path / "runs").iterdir()
        return Ran(status, folder, bench)

    return run_steps
