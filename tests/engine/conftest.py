"""A real device server with two scripted devices, and a way to run protocols on it."""

import asyncio
import json
import signal
import subprocess
import sys
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Thread

import pytest
import typer
from ruamel.yaml import YAML

from labrun.drivers.client.client import DeviceClient
from labrun.drivers.server.serve import serving
from labrun.drivers.server.settings import ServerSettings
from labrun.drivers.simulated.twins.bad_network import FaultyWire, WireFaults
from labrun.engine.check import check_file
from labrun.engine.commands import resume as resume_command
from labrun.engine.commands import run as run_command
from labrun.engine.commands.run import start
from labrun.engine.journal.journal import read_records
from labrun.schemas.messages import Goal

LAB = Path(__file__).parent / "scripted_lab"
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
        [sys.executable, "-m", "labrun.drivers.server.serve", str(folder / "config.json")],
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
    process.communicate()


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


@contextmanager
def served(settings):
    """A device server in a thread of its own; a wire to it, and the loop of that thread."""
    told = Future()

    async def serve():
        async with serving(ServerSettings.model_validate(settings)) as (_, url):
            wire, over = FaultyWire(url, WireFaults()), asyncio.Event()
            await wire.open()
            told.set_result((wire, asyncio.get_running_loop(), over))
            await over.wait()
            await wire.close()

    def live():
        try:
            asyncio.run(serve())
        except Exception as fault:  # a server that does not start is told where it is waited for
            told.set_exception(fault)

    thread = Thread(target=live)
    thread.start()
    wire, loop, over = told.result(20)
    yield wire, loop
    loop.call_soon_threadsafe(over.set)
    thread.join()


class OwnDevice:
    """A device `a` that no other test uses, on a wire that can be cut, and one run on it.

    The run can be cut short in its journal, as if its engine had been killed there.
    """

    def __init__(self, folder, wire, loop, contracts):
        self.folder, self.wire, self.loop = folder, wire, loop
        self.lab = folder / "lab.yaml"
        for name, contract in contracts.items():
            (folder / f"{name}.yaml").write_text(json.dumps(contract))
        types = {name: contract["type"] for name, contract in contracts.items()}
        devices = {name: {"contract": types[name], "url": wire.url} for name in types}
        lab = {"name": "own", "contracts": [f"./{n}.yaml" for n in types], "devices": devices}
        self.lab.write_text(json.dumps(lab))
        self.header = f"labrun: 1\nname: own\ndevices: {json.dumps(types)}\n"

    def run(self, body, *, beside="", answers=None, watch=None):
        """Run a protocol, with `beside` as `other.yaml`; `watch` is called with every event."""
        (self.folder / "other.yaml").write_text(self.header + beside)
        (self.folder / "p.yaml").write_text(self.header + body)
        checked = check_file(self.folder / "p.yaml", lab=self.lab, params={})
        assert checked.ok, checked.problems
        with self._watched(run_command, watch):
            return self._ran(start(checked, self.folder / "runs", answers=answers))

    def resume(self, *, answers=None, watch=None):
        """The same run goes on."""
        given = [f"{name}={choice}" for name, choice in (answers or {}).items()]
        with self._watched(resume_command, watch), pytest.raises(typer.Exit) as end:
            resume_command.resume("last", runs=self.folder / "runs", answer=given)
        return self._ran(end.value.exit_code)

    def kill_after(self, words):
        """Drop what the journal holds after the first record that contains these words."""
        (journal,) = self.folder.glob("runs/*/journal.jsonl")
        lines = journal.read_text().splitlines(keepends=True)
        last = next(n for n, line in enumerate(lines) if words in line)
        journal.write_text("".join(lines[: last + 1]), newline="\n")

    def answer(self, name, choice):
        """A person answers a question if it is open, from within `watch`."""
        if any(q.id == name and q.choice is None for q in self.questions.open.values()):
            self.questions.answer(name, choice, "the test")

    def abort(self):
        """A person aborts the run, from within `watch`; the second time at once."""
        self.control.ask("abort", "the test")

    def stop_by_hand(self):
        """Another client stops the device, which needs no lease."""
        self._by_another_client(lambda client: client.stop("a", by="the test (by hand)"))

    def use_by_hand(self):
        """Another client takes the lease, fires a shot, and gives the lease back."""

        async def use(client):
            epoch = await client.take_lease("a", "somebody")
            shot = {
                "id": "theirs/1",
                "device": "a",
                "action": "shoot",
                "params": {"name": "theirs"},
            }
            await client.follow(Goal(boot=client.boot, epoch=epoch, **shot))
            await client.release("a")

        self._by_another_client(use)

    def _by_another_client(self, deed):
        async def act():
            client = DeviceClient(self.wire.target)
            await client.open()
            try:
                await deed(client)
            finally:
                await client.close()

        asyncio.run(act())

    def break_wire(self):
        """Nothing passes until `mend_wire`."""
        self.reached, self.wire.target = self.wire.target, "http://127.0.0.1:1"
        self.loop.call_soon_threadsafe(self.wire.cut)

    def mend_wire(self):
        """New connections reach the server again."""
        self.wire.target = self.reached

    def _ran(self, status):
        (folder,) = (self.folder / "runs").iterdir()
        return Ran(status, folder, Bench(self.lab, self.folder / "world"))

    @contextmanager
    def _watched(self, command, watch):
        """Let `watch` hear what a command's run tells."""

        def begin(run, control):
            self.questions, self.control = run.questions, control
            return watch or (lambda event: None)

        kept = command.watcher
        command.watcher = lambda json: begin
        try:
            yield
        finally:
            command.watcher = kept


@pytest.fixture
def own_device(tmp_path):
    """Make one: the scripted device, with parts of its contract changed, or another driver.

    `also`: further devices on the same server, name -> (driver, contract).
    """
    with ExitStack() as ends:

        def make(driver=f"{LAB / 'scripted.py'}:Scripted", *, also=None, **changes):
            contract = YAML(typ="safe").load((LAB / "scripted.yaml").read_text()) | changes
            devices = {"a": (driver, contract), **(also or {})}
            settings = {
                "devices": {
                    name: {"contract": kept, "driver": str(driver), "config": {}}
                    for name, (driver, kept) in devices.items()
                },
                "folder": str(tmp_path / "server"), "world": str(tmp_path / "world"),
            }  # fmt: skip
            contracts = {name: kept for name, (_, kept) in devices.items()}
            return OwnDevice(tmp_path, *ends.enter_context(served(settings)), contracts)

        yield make
