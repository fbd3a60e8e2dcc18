"""The sessions of a run: an engine that dies at a chosen point, and others that resume the run."""

import asyncio
import contextlib
import json
import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

from ruamel.yaml import YAML

from labrun.drivers.client.client import DeviceClient, LeaseHeld
from labrun.engine.journal.journal import read_records

HERE = Path(__file__).parent
DEVICES = {"a": "bench@1", "b": "bare@1"}


@dataclass
class Story:
    """What a run and its devices left behind."""

    folder: Path
    status: int | str | None
    exits: list[int | str | None]
    happened: list[dict]
    words: str

    @property
    def records(self):
        return list(read_records(self.folder / "journal.jsonl"))

    def tell(self):
        """All of it, for a person who looks for the reason."""
        did = [(line["goal"].partition("/")[2], line["action"], line["name"], line["states"])
               for line in self.happened]  # fmt: skip
        return "\n".join([f"ended {self.exits}", self.words, *map(str, did), str(self.tables())])

    def tables(self):
        """The rows of every table by its header."""
        told = {}
        for path in sorted(self.folder.glob("data*.csv")):
            header, *rows = path.read_text().splitlines()
            told.setdefault(header, []).extend(rows)
        return told


def fate(folder):
    """How a run ended, by its last record; empty if it has not."""
    last = list(read_records(folder / "journal.jsonl"))[-1]
    return last.fate if last.kind == "finished" else ""


def write(folder, name, protocol):
    """A protocol as a file; those that it uses, which it holds as data, are written beside it."""
    used = []

    def with_names(part):
        if isinstance(part, list):
            return [with_names(one) for one in part]
        if not isinstance(part, dict):
            return part
        part = {key: with_names(value) for key, value in part.items()}
        if isinstance(part.get("use"), dict):
            if part["use"] not in used:
                used.append(part["use"])
            part["use"] = f"./{name}-{used.index(part['use'])}.json"
        return part

    whole = with_names(protocol)
    for index, other in enumerate(used):
        file = folder / f"{name}-{index}.json"
        file.write_text(json.dumps({"labrun": 1, "name": "used", **other}))
    file = folder / f"{name}.json"
    file.write_text(json.dumps({"labrun": 1, "name": name, "devices": DEVICES, **whole}))
    return file


@dataclass
class Laboratory:
    """One device server and one process that forks engines, for all tests."""

    folder: Path
    count: int = 0
    url: str = ""
    launcher: subprocess.Popen = field(init=False)

    def __post_init__(self):
        self.log = self.folder / "world" / "happened.jsonl"
        self.launcher = subprocess.Popen(
            [sys.executable, "-W", "error", str(HERE / "fork_server.py")],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        )  # fmt: skip
        ready = self._serve(0)
        self.url = ready["url"]
        self._settings(int(self.url.rpartition(":")[2]))
        lab = {
            "name": "crashes",
            "contracts": [str(HERE / "bench.yaml"), str(HERE / "bare.yaml")],
            "devices": {n: {"contract": kind, "url": self.url} for n, kind in DEVICES.items()},
        }
        (self.folder / "lab.yaml").write_text(json.dumps(lab))

    def close(self):
        self.launcher.communicate()

    def _settings(self, port):
        devices = {}
        for name, kind in DEVICES.items():
            stem = kind.partition("@")[0]
            contract = YAML(typ="safe").load((HERE / f"{stem}.yaml").read_text())
            devices[name] = {
                "contract": contract, "driver": f"{HERE / 'device.py'}:{stem.capitalize()}",
                "config": {"runs": str(self.folder / "runs")},
            }  # fmt: skip
        settings = {
            "devices": devices, "folder": str(self.folder / "server"), "port": port,
            "world": str(self.folder / "world"), "host": "127.0.0.1",
        }  # fmt: skip
        (self.folder / "server.json").write_text(json.dumps(settings))

    def _serve(self, port):
        self._settings(port)
        return self._tell("serve", settings=str(self.folder / "server.json"))

    def _tell(self, what, **more):
        print(json.dumps({"do": what, **more}), file=self.launcher.stdin, flush=True)
        return json.loads(self.launcher.stdout.readline())

    def live(self, protocol, kills=(), answers=None, tries=0):
        """Begin a run, kill and resume it as the schedule says, and let it come to its end.

        A kill is the number of a flush in that life of the engine; before, torn, after or later;
        and who touches the devices then: nobody, `stop` (or `stop a`), `restart`. A run that has
        failed is resumed up to `tries` times.
        """
        self.count += 1
        name, runs = f"n{self.count}", self.folder / "runs"
        log = self.folder / f"{name}.log"
        file = write(self.folder, name, protocol)
        given = ["--yes", *(f"--answer={i}={choice}" for i, choice in (answers or {}).items())]
        argv = ["run", str(file), "--lab", str(self.folder / "lab.yaml"), "--runs", str(runs)]
        exits = []
        for nth, when, touch in [*kills, *[(0, "", "")] * (1 + tries)]:
            kill = [nth, when] if nth else None
            told = self._tell("engine", argv=[*argv, *given], kill=kill, log=str(log))
            exits.append(told["exit"])
            found = list(runs.glob(f"*_{name}_*"))
            if len(found) != 1:
                raise RuntimeError(f"the run did not begin: {log.read_text()}")
            argv = ["resume", str(found[0])]
            over = fate(found[0])
            if tries and over == "failed":
                continue
            if told["exit"] != "killed":
                break
            if over:
                exits.append(0 if over == "succeeded" else 1)
                break
            self._touch(touch)
        if exits[-1] not in (0, 1) or "killed" in exits[-2:]:
            asyncio.run(self._release(found[0].name))
        return Story(found[0], exits[-1], exits, self._happened(found[0].name), log.read_text())

    def _touch(self, how):
        if how == "restart":
            self._tell("restart")
        elif how.startswith("stop"):
            asyncio.run(self._stop(how.partition(" ")[2] or None))

    async def _stop(self, device):
        client = DeviceClient(self.url)
        try:
            await client.open()
            await client.stop(device)
        finally:
            await client.close()

    async def _release(self, run):
        """Give back the leases of a run whose last engine did not end in order."""
        client = DeviceClient(self.url)
        try:
            await client.open()
            for device in DEVICES:
                with contextlib.suppress(LeaseHeld):
                    await client.take_lease(device, run)
                    await client.release(device)
        finally:
            await client.close()

    def _happened(self, run):
        lines = [json.loads(line) for line in self.log.read_text().splitlines()]
        return [line for line in lines if line["run"] == run]
