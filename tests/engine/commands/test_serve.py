"""Where `labrun serve` keeps the memory of its devices: in one place for a lab, wherever it is started."""

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer

from labrun.drivers.server.listen import for_other_machines
from labrun.engine.commands import serve
from labrun.engine.dispatch.served_lab import serve_home
from labrun.engine.lab.lab import load_lab
from labrun.system.process import alive

LAB = "name: mine\nsimulated: true\ndevices: {b: {contract: balance@1, driver: sim_balance}}\n"


@contextmanager
def serving(cwd, *words):
    """The first two lines of a server, in the order of the alphabet, and the process; ended in order."""
    process = subprocess.Popen(
        [sys.executable, "-m", "labrun.engine", "serve", *words, "--port", "0"],
        cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    try:
        yield *sorted((process.stdout.readline(), process.stdout.readline())), process
    finally:
        process.send_signal(signal.SIGTERM)
        process.communicate()


def folder_of(line: str) -> Path:
    return Path(line.removeprefix("ledgers and logs in ").strip())


@pytest.mark.slow
def test_a_lab_has_one_folder_from_wherever_it_is_served_and_another_lab_another(tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    for folder in (here, there):
        folder.mkdir()
        (folder / "lab.yaml").write_text(LAB)
    with serving(here, "lab.yaml") as (at, line, _):
        first = folder_of(line)

        assert at.startswith("b at http://127.0.0.1:")
        assert (first / "b" / "ledger.sqlite").exists()
    with serving(there, str(here / "lab.yaml")) as (_, line, _):
        again = folder_of(line)
    with serving(there, "lab.yaml") as (_, line, _):
        other = folder_of(line)

    assert first == again != other


@pytest.mark.parametrize("host", ["0.0.0.0", "::", ""])
def test_who_listens_on_every_address_says_what_another_machine_can_use(host):
    said = for_other_machines(host, "https://127.0.0.1:4101")

    assert said.startswith("; other machines reach it at https://")
    assert said.endswith(f"https://{socket.gethostname()}:4101")
    assert "127.0.0.1" not in said
    assert for_other_machines("10.0.0.7", "http://10.0.0.7:4101") == ""


@pytest.mark.slow
def test_ledgers_of_an_earlier_version_are_pointed_at(tmp_path):
    (tmp_path / "lab.yaml").write_text(LAB)
    (tmp_path / ".labrun" / "servers").mkdir(parents=True)
    with serving(tmp_path, "lab.yaml") as (_, _, process):
        assert process.stderr is not None
        said = process.stderr.readline()

    assert "`--folder .labrun/servers` continues with them" in said


@pytest.mark.slow
def test_a_server_that_dies_is_said_and_started_again_at_its_address(tmp_path):
    (tmp_path / "lab.yaml").write_text(LAB)
    with serving(tmp_path, "lab.yaml") as (at, line, process):
        assert process.stderr is not None
        served = folder_of(line) / "b" / "server.json"
        before = json.loads(served.read_text())
        os.kill(before["pid"], signal.SIGKILL)
        lines = (line for line in process.stderr if "waiting for" not in line)
        said = [next(lines), next(lines)]
        after = json.loads(served.read_text())

    assert "the server of b has died, see " in said[0] and "again in 0.5 s" in said[0]
    assert said[1].strip() == f"labrun: {at.strip()} again"
    assert after["pid"] != before["pid"] and after["url"] == before["url"]


DIES = """
import asyncio, json, os
from labrun.drivers.simulated.balance import SimBalance

class Dies(SimBalance):
    async def open(self):
        await super().open()
        self.dying = asyncio.create_task(self.die())

    async def die(self):
        folder = self.place.folder
        files = [f / "server.json" for f in (folder, *folder.parents)]
        while os.getpid() not in [json.loads(f.read_text())["pid"] for f in files if f.exists()]:
            await asyncio.sleep(0.05)
        await asyncio.sleep(0.3)
        os._exit(3)
"""
"""Dies soon after it has said that it serves, whenever that is."""


@pytest.mark.slow
def test_a_server_that_goes_on_dying_ends_the_command_with_a_status(tmp_path):
    (tmp_path / "dies.py").write_text(DIES)
    (tmp_path / "lab.yaml").write_text(LAB.replace("sim_balance", "./dies.py:Dies"))
    with serving(tmp_path, "lab.yaml") as (_, _, process):
        assert process.stderr is not None
        said = process.stderr.read()

        assert process.wait() == 1
    assert said.count("it starts again in") == 4
    assert "5 times, so it is given up" in said


@pytest.mark.slow
def test_a_command_that_is_killed_leaves_no_server_behind(tmp_path):
    (tmp_path / "lab.yaml").write_text(LAB)
    with serving(tmp_path, "lab.yaml") as (_, line, process):
        served = folder_of(line) / "b" / "server.json"
        pid = json.loads(served.read_text())["pid"]
        process.kill()
        process.wait()
        until = time.monotonic() + 500
        while alive(pid) and time.monotonic() < until:
            time.sleep(0.05)

        assert not alive(pid)
        assert not served.exists()  # it has ended in order


def test_the_servers_of_a_lab_start_beside_each_other(tmp_path, monkeypatch, capsys):
    (tmp_path / "lab.yaml").write_text(
        LAB.replace("devices: {", "devices: {a: {contract: balance@1, driver: sim_balance}, ")
    )
    lab = load_lab(tmp_path / "lab.yaml")[0]
    configs = [{"folder": str(tmp_path / n), "devices": {n: {}}, "host": "127.0.0.1"} for n in "ab"]
    servers, keeping, starting = [], [], []
    both = asyncio.Event()

    async def start(config, folder, **_):
        starting.append(folder.name)
        if len(starting) == 2:
            both.set()
        await both.wait()  # for ever, if one is only begun when the other is there
        return SimpleNamespace(url=f"http://127.0.0.1/{folder.name}")

    async def kept(*_, **__):
        pass

    monkeypatch.setattr("labrun.drivers.client.launch.start_patiently", start)
    monkeypatch.setattr("labrun.drivers.client.launch.keep_running", kept)

    async def story():
        async with asyncio.timeout(60):
            await serve._start(configs, lab, servers, keeping)
        await asyncio.gather(*keeping)

    asyncio.run(story())

    assert sorted(one.url[-1] for one in servers) == ["a", "b"]
    assert "b at http://127.0.0.1/b\n" in capsys.readouterr().out


SLOW = """
import asyncio
from labrun.drivers.simulated.balance import SimBalance

class Slow(SimBalance):
    async def open(self):
        await super().open()
        await asyncio.sleep(60)
"""


@pytest.mark.slow
def test_a_slow_start_says_what_it_waits_for_and_an_end_does_not_wait_for_it(tmp_path):
    (tmp_path / "slow.py").write_text(SLOW)
    (tmp_path / "lab.yaml").write_text(
        "start_timeout: 40 s\n" + LAB.replace("sim_balance", "./slow.py:Slow")
    )
    words = [sys.executable, "-m", "labrun.engine", "serve", "lab.yaml", "--port", "0"]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        said = process.stderr.readline()
        process.terminate()

        assert process.wait() == 0
    assert said == (
        "labrun: waiting for the server of b to start, 40 s at most (`start_timeout`)\n"
    )


@pytest.mark.soak
def test_an_instrument_out_of_reach_keeps_no_other_from_being_served(tmp_path):
    (tmp_path / "lab.yaml").write_text(
        LAB.replace(
            "{b: {",
            f"{{a: {{contract: balance@1, driver: balance, config: {{port: {tmp_path}/no}}}}, b: {{",
        )
    )
    with serving(tmp_path, "lab.yaml") as (_, at, process):
        assert process.stderr is not None
        said = next(line for line in process.stderr if "waiting for" not in line)
        away, there = (
            labrun(tmp_path, "call", f"{name}.weigh", "--lab", "lab.yaml") for name in "ab"
        )
        stopped = labrun(tmp_path, "stop", "a", "--lab", "lab.yaml")
    alone = labrun(tmp_path, "serve", "lab.yaml", "a", "--port", "0")

    why = f"device a cannot be opened: there is no port {tmp_path}/no"
    assert at.startswith("b at ") and said.startswith(f"labrun: {why}")
    assert away.returncode == alone.returncode == 4
    assert f": {why}" in away.stderr and away.stderr.endswith("Nothing was sent.\n")
    assert there.returncode == 0, there.stderr
    assert stopped.returncode == 1 and f"a may not be safe: {why}" in stopped.stderr


@pytest.mark.parametrize("chosen", ["no port", "by the lab", "--port"])
def test_a_second_lab_takes_other_ports_or_says_who_holds_the_one_that_it_names(
    tmp_path, capsys, monkeypatch, chosen
):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        monkeypatch.setattr(serve, "FIRST_PORT", port)
        (tmp_path / "first.yaml").write_text(LAB)
        own = f", port: {port}" if chosen == "by the lab" else ""
        (tmp_path / "second.yaml").write_text(LAB.replace("sim_balance", f"sim_balance{own}"))
        first, second = (load_lab(tmp_path / f"{name}.yaml")[0] for name in ("first", "second"))
        server = serve_home(first) / "b" / "server.json"
        server.parent.mkdir(parents=True)
        words = {
            "pid": os.getpid(),
            "owner": 7,
            "url": f"http://127.0.0.1:{port}",
            "devices": ["b"],
        }
        server.write_text(json.dumps(words))
        server.with_name("server_settings.json").write_text(json.dumps({"base": "/labs"}))
        asked = {"port": port if chosen == "--port" else None, "host": "127.0.0.1", "one": False}
        try:
            (config,) = serve._configs(second, None, serve_home(second), token=None, **asked)
        except typer.Exit as end:
            config = {"status": end.exit_code}

    said = capsys.readouterr().err
    holder = f"port {port} is in use by b of the lab 'first' in /labs (process 7)"
    assert holder in said
    assert config["port"] > port if chosen == "no port" else config == {"status": 4}


def labrun(cwd, *words):
    return subprocess.run(
        [sys.executable, "-m", "labrun.engine", *words], cwd=cwd, capture_output=True, text=True
    )


@pytest.mark.slow
def test_a_device_that_is_served_is_used_there_on_whatever_port_from_whatever_folder(tmp_path):
    (tmp_path / "lab.yaml").write_text(
        LAB.replace("{b: {", "{c: {contract: balance@1, driver: sim_balance}, b: {")
    )
    (tmp_path / "weigh.yaml").write_text(
        "labrun: 1\nname: weigh\ndevices: {b: balance@1}\nsteps: [{do: b.weigh}]\n"
    )
    with serving(tmp_path, "lab.yaml", "--folder", "elsewhere") as (at, _, _):
        url = at.removeprefix("b at ").strip()
        called = labrun(tmp_path, "call", "b.weigh", "--lab", "lab.yaml")
        run = labrun(tmp_path, "run", "weigh.yaml", "--lab", "lab.yaml")
        stopped = labrun(tmp_path, "stop", "b", "--lab", "lab.yaml")
    alone = labrun(tmp_path, "call", "b.weigh", "--lab", "lab.yaml")

    for used in (called, run):
        assert used.returncode == 0, used.stderr
        assert f"b is served at {url} by another command" in used.stderr + used.stdout
    assert int(url.rpartition(":")[2]) > 1023  # free ones for all of them, not 0, 1, 2
    assert (stopped.returncode, stopped.stdout.strip()) == (0, "b is in its safe state")
    (folder,) = (tmp_path / "runs").iterdir()
    assert not (folder / "servers" / "b").exists()
    assert alone.returncode == 0 and "is served at" not in alone.stderr
