"""Protocols on the real engine and three scripted devices: to the end, aborted, killed and resumed."""

import asyncio
import contextlib
import json
import re
import signal
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from threading import Thread

import pytest
import typer
from ruamel.yaml import YAML

from labrun.drivers.client.client import DeviceClient
from labrun.engine.check import check_file
from labrun.engine.commands import resume as resume_command
from labrun.engine.commands import run as run_command
from labrun.engine.control.server import NotLive, ask_run
from labrun.engine.journal.journal import read_records
from labrun.engine.runner import runner

HERE = Path(__file__).parent
LAB = HERE.parent / "scripted_lab"
PAUSE_S = 0.6
DEVICES = ("a", "b", "c")
HEADER = "labrun: 1\nname: {}\ndevices: {{a: scripted@1, b: scripted@1, c: scripted@1}}\n"


@dataclass
class Ran:
    """What a run, all its lives taken together, has left behind."""

    status: int
    folder: Path
    calls: list[dict]
    said: list[str] = field(default_factory=list)

    @property
    def records(self):
        return list(read_records(self.folder / "journal.jsonl"))

    @property
    def finished(self):
        return self.records[-1]

    @property
    def outputs(self):
        return self.finished.outputs

    @property
    def sent(self):
        """Names of what the devices began to do, in order."""
        return [c["name"] for c in self.calls if c["word"] != "done"]

    @property
    def done(self):
        """Names of what the devices did to the end, in order."""
        return [c["name"] for c in self.calls if c["word"] == "done"]

    @property
    def words(self):
        """Begun as `name`, done as `name.`, in order."""
        return [c["name"] + "." * (c["word"] == "done") for c in self.calls]

    @property
    def logged(self):
        """The lines of `log` steps."""
        return [r.message for r in self.records if r.kind == "step" and r.message]

    def rows(self, name="data.csv"):
        header, *lines = (self.folder / name).read_text().splitlines()
        names = header.split(",")
        return [dict(zip(names, line.split(","), strict=True)) for line in lines]


@dataclass
class Laboratory:
    """The devices as they are served, and a process that forks engines which are to die."""

    lab: Path
    log: Path
    forks: subprocess.Popen
    count: int = 0

    def calls(self, run):
        written = self.log.read_text() if self.log.exists() else ""
        lines = [json.loads(line) for line in written.splitlines()]
        return [line for line in lines if line.get("run") == run]

    def live_until(self, moment, argv, words, change=None):
        order = {
            "until": moment, "argv": [str(word) for word in argv], "log": str(words),
            "change": change,
        }  # fmt: skip
        print(json.dumps(order), file=self.forks.stdin, flush=True)
        return json.loads(self.forks.stdout.readline())


@pytest.fixture(scope="session")
def laboratory(tmp_path_factory):
    """One server for all runs: their calls are told apart by the run's name."""
    folder = tmp_path_factory.mktemp("semantics")
    contract = YAML(typ="safe").load((LAB / "scripted.yaml").read_text())
    device = {"contract": contract, "driver": f"{LAB / 'scripted.py'}:Scripted", "config": {}}
    config = {
        "devices": dict.fromkeys(DEVICES, device), "folder": str(folder / "server"),
        "world": str(folder / "world"), "host": "127.0.0.1", "port": 0,
    }  # fmt: skip
    (folder / "config.json").write_text(json.dumps(config))
    pipes = {"stdout": subprocess.PIPE, "text": True, "start_new_session": True}
    server = subprocess.Popen(
        [sys.executable, "-m", "labrun.drivers.server.serve", str(folder / "config.json")], **pipes
    )
    forks = subprocess.Popen(
        [sys.executable, "-W", "error", str(HERE / "mortal.py")], stdin=subprocess.PIPE, **pipes
    )
    url = json.loads(server.stdout.readline())["url"]
    lines = [f"  {name}: {{contract: scripted@1, url: '{url}'}}" for name in DEVICES]
    lab = folder / "lab.yaml"
    lab.write_text(
        f"name: scripted\ncontracts: [{LAB / 'scripted.yaml'}]\ndevices:\n" + "\n".join(lines)
    )
    yield Laboratory(lab, folder / "world" / "calls.jsonl", forks)
    forks.communicate()
    server.send_signal(signal.SIGTERM)
    server.communicate()


@dataclass
class Bench:
    """One test's protocol and its runs."""

    laboratory: Laboratory
    folder: Path
    asking: Thread | None = None

    def write(self, body, beside=None):
        """The protocol, and other files beside it; each protocol gets a header.

        Its name is new each time: two runs of one name may have the same id, in folders of their own.
        """
        self.laboratory.count += 1
        for name, text in {**(beside or {}), "test.yaml": body}.items():
            header = HEADER.format(f"t{self.laboratory.count}") if name.endswith(".yaml") else ""
            (self.folder / name).write_text(header + text, encoding="utf-8")
        return self.folder / "test.yaml"

    def run(self, body, *, beside=None, params=None, yes=False, answers=None, **steers):
        """One run to its end; `abort`, `pause`, `go_on` say at which moment it is told so."""
        path = self.write(body, beside)
        checked = check_file(path, lab=self.laboratory.lab, params=params or {})
        assert checked.ok, checked.problems
        with self._steered(steers) as said:
            status = run_command.start(
                checked, self.folder / "runs", given=params, yes=yes, answers=answers
            )
        return self._ran(status, said)

    def kill_again(self, moment, *options):
        """Resume the run, with an engine that is killed at a moment."""
        argv = ["resume", "last", "--runs", self.folder / "runs", *options]
        told = self.laboratory.live_until(moment, argv, self.folder / "words.txt")
        assert told["exit"] == -signal.SIGKILL, told
        return self._ran(-signal.SIGKILL, [])

    def kill(self, body, moment, *, beside=None, params=None, answers=None, change=None):
        """A run whose engine is killed at a moment: `KIND PATH`, as in mortal.py.

        `change`: at which event it is to be changed, and to what.
        """
        path = self.write(body, beside)
        given = [f"-p{name}={value}" for name, value in (params or {}).items()]
        asked = [f"--answer={name}={value}" for name, value in (answers or {}).items()]
        told = self.laboratory.live_until(
            moment,
            [
                "run",
                path,
                "--lab",
                self.laboratory.lab,
                "--runs",
                self.folder / "runs",
                *given,
                *asked,
            ],
            self.folder / "words.txt",
            change and {"at": change[0], "file": self.changed(change[1])},
        )
        assert told["exit"] == -signal.SIGKILL, told
        return self._ran(-signal.SIGKILL, [])

    def resume(
        self, *, yes=False, answers=None, holes=False, point=(), by="Ada", changed=None, **steers
    ):
        """The same run goes on, with another protocol if `changed`, or measures its holes again."""
        given = [f"{name}={choice}" for name, choice in (answers or {}).items()]
        with self._steered(steers) as said:
            try:
                resume_command.resume(
                    "last", holes=holes, point=list(point), by=by, runs=self.folder / "runs",
                    answer=given, yes=yes, changed=changed and Path(self.changed(changed)),
                )  # fmt: skip
            except typer.Exit as end:
                status = end.exit_code
        return self._ran(status, said)

    def changed(self, body):
        """A changed protocol in a file of its own."""
        file = self.folder / "changed.yaml"
        file.write_text(HEADER.format(f"t{self.laboratory.count}") + body, encoding="utf-8")
        return str(file)

    def change(self, folder, body, said, **more):
        """Another shell asks for a change of a live run; what it is answered comes to `said`."""
        asked = {"verb": "change", "file": self.changed(body), "by": "Ada", **more}

        def ask():
            with contextlib.suppress(NotLive):
                said.append(ask_run(folder, asked, None))

        self.asking = Thread(target=ask)
        self.asking.start()

    def _ran(self, status, said):
        (folder,) = (self.folder / "runs").iterdir()
        return Ran(status, folder, self.laboratory.calls(folder.name), said)

    @contextlib.contextmanager
    def _steered(self, steers):
        """Tell the run `abort` or `pause` when something like KIND STATE PATH is told."""
        said = []

        def watch(run, control):
            def told(event):
                text = f"{event.event} {event.state} {event.path}"
                if event.event == "log":
                    said.append(event.text)
                for verb, pattern in list(steers.items()):
                    if verb in ("change", "answer"):
                        pattern, body = pattern
                    is_early = verb == "go_on" and "stop" in steers
                    if re.search(pattern, text) and not is_early:
                        del steers[verb]
                        if verb == "change":
                            self.change(run.folder, body, said)
                        elif verb == "answer":
                            run.questions.answer(event.data["id"], body, "the test")
                        else:
                            _tell(control, verb, self)

            return told

        kept = run_command.watcher, resume_command.watcher
        run_command.watcher = resume_command.watcher = lambda json: watch
        try:
            yield said
        finally:
            run_command.watcher, resume_command.watcher = kept
        assert not steers, f"never came: {steers}"


def _tell(control, verb, bench):
    """`pause` is over after a while, and once a change is answered; `go_on` ends a pause that the
    protocol has asked for.

    `stop`: another client stops the device `a`.
    """
    if verb == "stop":
        told = Thread(target=asyncio.run, args=(_stop(control.run),))
        told.start()
        return
    if verb in ("pause", "go_on"):
        loop = asyncio.get_running_loop()

        def go_on():
            if bench.asking is not None and bench.asking.is_alive():
                loop.call_later(PAUSE_S, go_on)
            else:
                control.ask("continue", "the test")

        loop.call_later(PAUSE_S, go_on)
    if verb != "go_on":
        control.ask(verb.partition("_")[0], "the test")


async def _stop(run):
    client = DeviceClient(_url(run))
    await client.open()
    try:
        await client.stop("a", by="Ada (the STOP button)")
    finally:
        await client.close()


def _url(run):
    lab = YAML(typ="safe").load((run.folder / "lab.yaml").read_text())
    return lab["devices"]["a"]["url"]


@pytest.fixture
def bench(laboratory, tmp_path, monkeypatch):
    # Reports are made after a run's last record: nothing here is about them.
    monkeypatch.setattr(runner, "make_reports", lambda folder: ([], []))
    return Bench(laboratory, tmp_path)


@pytest.fixture
def run(bench):
    return bench.run


@pytest.fixture
def compare(run):
    """Run a protocol, and compare what it leaves behind with what is expected (see table.py)."""

    def compared(body, left, how):
        ran = run(body, **how)
        exact = {name: value for name, value in left.items() if name != "reason"}
        found = {name: getattr(ran if hasattr(ran, name) else ran.finished, name) for name in exact}

        assert found == exact
        assert left.get("reason", "") in f"{ran.finished.reason} {ran.finished.detail}"

    return compared
