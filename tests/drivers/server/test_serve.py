"""A device server as a process: one line says how it started, and it never ends unsafe."""

import asyncio
import json
import os
import signal
import socket
import ssl
import subprocess
import sys
from pathlib import Path

import pytest

from labrun.drivers.client.launch import start_server
from labrun.drivers.server.ledger import Ledger
from labrun.drivers.server.serve import ServeFault, main, read_settings, serve

IN_USE = "" if os.name == "nt" else "Address already in use"
"""What Windows says is in the language of its user."""


def start(bench, capsys, settings):
    """What the process would have printed, and its exit status."""
    path = bench.folder / "settings.json"
    path.write_text(settings if isinstance(settings, str) else json.dumps(settings))
    status = main([str(path)])
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 1
    return json.loads(lines[0]), status


def changed(settings, **device):
    settings["devices"]["arm"].update(device)
    return settings


FAULTS = [
    (lambda b: changed(b.settings(), driver="sim_gantri"), "device arm: there is no driver"),
    (lambda b: changed(b.settings(), driver="sim_gantry"), "does not keep the contract scripted@1"),
    (lambda b: changed(b.settings(), contract={"type": "x"}), "device arm: its contract: type: "),
    (lambda b: changed(b.settings(), limits={"q": [0, 1]}), "device arm: limit q: no action of"),
    (
        lambda b: b.settings(config={"missing": True}),
        "device arm cannot be opened: nothing answers on /dev/nowhere",
    ),
    (
        lambda b: b.settings(host="0.0.0.0"),
        "0.0.0.0 can be reached from other machines, so a token",
    ),
    (lambda b: b.settings(port=70000), "port: Input should be less than or equal to 65535"),
    (lambda b: b.settings(colour="red"), "colour: Extra inputs are not permitted"),
    (
        lambda b: b.settings(tls={"certificate": "no.pem", "key": "no.pem"}),
        "the certificate no.pem with the key no.pem cannot be used",
    ),
    (lambda b: "{", "settings"),
]


@pytest.mark.parametrize(("settings", "words"), FAULTS)
def test_a_server_that_cannot_start_says_why_in_one_line(bench, capsys, settings, words):
    said, status = start(bench, capsys, settings(bench))

    assert said["ready"] is False
    assert words in said["error"]
    assert status == 4


def test_a_port_in_use_is_a_sentence(bench, capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        said, status = start(bench, capsys, bench.settings(port=port))

    assert f"port {port} on 127.0.0.1 cannot be used: {IN_USE}" in said["error"]
    assert status == 4


def test_a_ledger_in_use_is_a_sentence(bench, capsys):
    ledger = Ledger(bench.folder / "server" / "ledger.sqlite")
    said, _ = start(bench, capsys, bench.settings())
    ledger.close()

    assert "another device server is using" in said["error"]


def test_an_instrument_that_has_a_server_is_a_sentence_until_that_has_ended(bench, capsys):
    what = f"the arm of {bench.folder}"

    async def story():
        async with bench.serving(config={"alone": what}):
            path = bench.folder / "settings.json"
            path.write_text(json.dumps(other))
            with pytest.raises(ServeFault, match="has a device server already") as told:
                await serve(read_settings(path))
        return str(told.value)

    other = bench.settings(config={"alone": what}, folder=str(bench.folder / "other"))
    told = asyncio.run(story())

    assert told == (
        f"device arm cannot be opened: {what} has a device server already (process {os.getpid()}): "
        "wait until the run, call or `labrun serve` that started that has ended, or end it"
    )
    other["devices"]["arm"]["config"]["missing"] = True
    assert "nothing answers" in start(bench, capsys, other)[0]["error"]


def test_a_settings_file_that_is_not_there_is_a_sentence(tmp_path, capsys):
    status = main([str(tmp_path / "none.json")])

    assert "No such file or directory" in json.loads(capsys.readouterr().out)["error"]
    assert status == 4


@pytest.mark.posix("Windows ends a process without asking it")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_in_order(bench, number):
    async def story():
        server = await start_server(bench.settings(), bench.folder)
        async with bench.client(server.url) as client:
            following = asyncio.create_task(client.follow(bench.goal(client, "hold", seconds=30)))
            await bench.until("hold run-1/main/1/1")
            os.kill(server.pid, number)
            outcome = await following
            return outcome, await asyncio.wait_for(server.process.wait(), 500)

    outcome, status = asyncio.run(story())

    assert (outcome.state, status) == ("CANCELED", 0)
    assert bench.deeds()[-1] == "arm close"
    assert "arm safe" in bench.deeds()
    assert "Traceback" not in (bench.folder / "server.log").read_text()
    assert not (bench.folder / "server" / "server.json").exists()


def test_it_ends_by_itself_when_nobody_needs_it_any_more(bench):
    async def story():
        server = await start_server(bench.settings(idle_exit_s=0.5), bench.folder)
        async with bench.client(server.url, lease=False) as client:
            await client.take_lease("arm", "run-1", ttl_s=1.0)
            await asyncio.sleep(1.5)
            needed = server.process.returncode
        return needed, await asyncio.wait_for(server.process.wait(), 500)

    needed, status = asyncio.run(story())

    assert (needed, status) == (None, 0)
    assert "arm safe" in bench.deeds()


def test_it_stays_as_long_as_its_owner_lives(bench):
    owner = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)

    async def story():
        settings = bench.settings(idle_exit_s=0.2, owner_pid=owner.pid)
        server = await start_server(settings, bench.folder)
        await asyncio.sleep(1.0)
        needed = server.process.returncode
        owner.communicate(b"\n")
        return needed, await asyncio.wait_for(server.process.wait(), 500)

    assert asyncio.run(story()) == (None, 0)


@pytest.mark.posix("an open file can be taken away")
@pytest.mark.soak
def test_a_server_whose_folder_was_replaced_ends_once_nobody_holds_a_device(bench):
    async def story():
        server = await start_server(bench.settings(), bench.folder)
        async with bench.client(server.url) as client:
            (bench.folder / "server").rename(bench.folder / "old")
            outcome = await client.follow(bench.goal(client, "hold", seconds=0))
            needed = server.process.returncode
        return needed, outcome, await asyncio.wait_for(server.process.wait(), 500)

    needed, outcome, status = asyncio.run(story())

    assert (needed, outcome.state, status) == (None, "ABORTED", 0)
    assert "was removed while this server had it" in outcome.error.message
    assert "It ends." in (bench.folder / "server.log").read_text()


def test_with_its_owner_it_ends_once_nobody_holds_a_device_whoever_looks_on(bench):
    owner = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)

    async def story():
        settings = bench.settings(ends_with_owner=True, owner_pid=owner.pid)
        server = await start_server(settings, bench.folder)
        async with (
            bench.client(server.url, lease=False),  # a page that looks on
            bench.client(server.url) as client,
        ):
            owner.communicate(b"\n")
            outcome = await client.follow(bench.goal(client, "hold", seconds=1))
            needed = server.process.returncode
            await client.release("arm")
            return needed, outcome.state, await asyncio.wait_for(server.process.wait(), 500)

    assert asyncio.run(story()) == (None, "SUCCEEDED", 0)
    assert bench.deeds()[-1] == "arm close"


def test_it_speaks_tls_where_it_is_given_a_certificate(bench, tmp_path, monkeypatch):
    certificate, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    made = subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
         "-nodes", "-days", "2", "-subj", "/CN=127.0.0.1", "-addext", "subjectAltName=IP:127.0.0.1",
         "-keyout", str(key), "-out", str(certificate)],
        capture_output=True, check=False,
    )  # fmt: skip
    if made.returncode:
        pytest.skip("openssl is not there to make a certificate")
    monkeypatch.setenv("SSL_CERT_FILE", str(certificate))
    trusting = ssl.create_default_context(cafile=str(certificate))
    monkeypatch.setattr("aiohttp.connector._SSL_CONTEXT_VERIFIED", trusting)

    async def story():
        tls = {"certificate": str(certificate), "key": str(key)}
        async with bench.serving(tls=tls) as (_, url), bench.client(url) as client:
            return url, await client.follow(bench.goal(client, "go", x=1))

    url, outcome = asyncio.run(story())

    assert url.startswith("https://")
    assert outcome.state == "SUCCEEDED"


def test_nothing_heavy_is_loaded_to_serve():
    heavy = ("numpy", "scipy", "pint", "matplotlib", "py_trees", "ruamel")
    script = (
        f"import labrun.drivers.server.serve, sys; print(sorted(set({heavy}) & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )

    assert done.stdout.strip() == "[]"


def test_a_device_whose_server_was_killed_is_calmed_by_the_next(bench):
    async def story():
        first = await start_server(bench.settings(), bench.folder)
        async with bench.client(first.url) as client:
            following = asyncio.create_task(client.follow(bench.goal(client, "press", seconds=30)))
            await bench.until("press run-1/main/1/1")
            first.process.kill()
            await first.process.wait()
            following.cancel()
        before = bench.deeds()
        async with bench.serving():
            return before, bench.deeds()

    before, after = asyncio.run(story())

    assert "arm safe" not in before
    assert "arm safe" in after


def test_the_folders_it_needs_are_made(bench):
    async def story():
        async with bench.serving():
            return sorted(path.name for path in Path(bench.folder).iterdir())

    assert asyncio.run(story()) == ["server", "world"]
