"""A run that cannot resume reports why and what to do, and sends nothing."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from labrun.engine.journal.journal import chain, read_records

LAB = Path(__file__).parents[1] / "scripted_lab"
PROTOCOL = """labrun: 1
name: stopped
devices: {a: scripted@1}
steps:
  - {do: a.act, with: {name: first}}
  - {do: a.act, with: {name: second, script: Broken}}
"""


def labrun(*words):
    return subprocess.run(
        [sys.executable, "-m", "labrun.engine", *map(str, words)],
        capture_output=True, text=True,
    )  # fmt: skip


def serve(folder, contract, port=0):
    """A server of our own with one device `a`; the process and its address."""
    device = {"contract": contract, "driver": f"{folder / 'scripted.py'}:Scripted", "config": {}}
    settings = {
        "devices": {"a": device}, "folder": str(folder / f"server{port}"),
        "world": str(folder / "world"), "host": "127.0.0.1", "port": port,
    }  # fmt: skip
    (folder / "settings.json").write_text(json.dumps(settings))
    process = subprocess.Popen(
        [sys.executable, "-m", "labrun.drivers.server.serve", str(folder / "settings.json")],
        stdout=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    assert process.stdout is not None
    return process, json.loads(process.stdout.readline())["url"]


@pytest.fixture
def stopped(tmp_path):
    """A run that failed, its lab's server, and a way to replace it by another."""
    from ruamel.yaml import YAML

    contract = YAML(typ="safe").load((LAB / "scripted.yaml").read_text())
    (tmp_path / "scripted.py").write_text((LAB / "scripted.py").read_text())
    process, url = serve(tmp_path, contract)
    (tmp_path / "lab.yaml").write_text(
        f"name: l\ncontracts: [{LAB / 'scripted.yaml'}]\n"
        f"devices: {{a: {{contract: scripted@1, url: '{url}'}}}}\n"
    )
    (tmp_path / "p.yaml").write_text(PROTOCOL)
    ended = labrun(
        "run", tmp_path / "p.yaml", "--lab", tmp_path / "lab.yaml", "--runs", tmp_path / "runs"
    )
    assert ended.returncode == 1, ended.stderr
    servers = [process]

    def replace(change=None):
        servers[-1].kill()
        servers[-1].communicate()
        if change is not None:
            port = int(url.rpartition(":")[2])
            servers.append(serve(tmp_path, change(dict(contract)), port)[0])

    yield next((tmp_path / "runs").iterdir()), replace
    if servers[-1].poll() is None:
        servers[-1].kill()
        servers[-1].communicate()


@pytest.mark.soak
def test_a_device_that_is_gone_is_named_with_its_address(stopped):
    run, replace = stopped
    replace()
    records = len(list(read_records(run / "journal.jsonl")))
    ended = labrun("resume", run)

    assert ended.returncode == 4
    assert "device 'a' at http://127.0.0.1:" in ended.stderr
    assert "cannot be reached" in ended.stderr and "Nothing was sent" in ended.stderr
    assert len(list(read_records(run / "journal.jsonl"))) == records + 1  # `resumed`, nothing else


@pytest.mark.soak
def test_a_device_of_another_contract_version_is_refused(stopped):
    run, replace = stopped
    source = run.parent.parent / "scripted.py"
    source.write_text(source.read_text().replace("scripted@1", "scripted@2"))
    replace(lambda contract: {**contract, "type": "scripted@2"})
    ended = labrun("resume", run)

    assert ended.returncode == 4
    assert "keeps scripted@2, but the protocol needs scripted@1" in ended.stderr
    assert "Nothing was sent" in ended.stderr


@pytest.mark.slow
def test_a_server_with_another_ledger_is_taken_and_its_device_counts_as_touched(stopped):
    run, replace = stopped
    replace(lambda contract: contract)
    ended = labrun("resume", run)

    assert ended.returncode == 1, ended.stderr  # the second step is scripted to fail
    touched = [r for r in read_records(run / "journal.jsonl") if r.kind == "touched"]
    assert [(r.device, r.reason) for r in touched] == [("a", "its server was restarted")]


@pytest.mark.slow
def test_a_device_that_somebody_used_by_hand_meanwhile_counts_as_touched(stopped):
    run, _ = stopped
    lab = run.parent.parent / "lab.yaml"
    by_hand = labrun("call", "a.act", "name=mine", "--lab", lab)
    ended = labrun("resume", run)

    assert by_hand.returncode == 0, by_hand.stderr
    assert ended.returncode == 1, ended.stderr
    touched = [r for r in read_records(run / "journal.jsonl") if r.kind == "touched"]
    assert [(r.device, r.reason) for r in touched] == [
        ("a", "another client held or stopped it in between")
    ]


def rewrite(journal, change):
    """A journal as another program may have written it: its own chain, other records."""
    previous, lines = "", []
    for line in journal.read_text().splitlines():
        record = change(json.loads(line))
        del record["hash"]
        body = json.dumps(record, separators=(",", ":"))[:-1]
        previous = chain(previous, body)
        lines.append(f'{body},"hash":"{previous}"}}\n')
    journal.write_text("".join(lines), newline="\n")


@pytest.mark.soak
def test_a_journal_of_a_newer_labrun_is_refused(stopped):
    run, _ = stopped
    rewrite(run / "journal.jsonl", lambda r: {**r, "format": 99} if r["kind"] == "started" else r)
    ended = labrun("resume", run)

    assert ended.returncode == 2
    assert "is written in journal format 99; this labrun reads format 3" in ended.stderr


@pytest.mark.slow
@pytest.mark.parametrize("hours", [-5, pytest.param(5, marks=pytest.mark.soak)])
def test_a_clock_that_jumped_loses_nothing_and_tells_nothing_of_a_device(stopped, hours):
    from datetime import datetime, timedelta

    run, _ = stopped

    def moved(record):
        at = datetime.fromisoformat(record["at"]) + timedelta(hours=hours)
        return {**record, "at": at.isoformat()}

    rewrite(run / "journal.jsonl", moved)
    ended = labrun("resume", run)
    records = list(read_records(run / "journal.jsonl"))

    assert ended.returncode == 1, ended.stderr
    assert [r.device for r in records if r.kind == "touched"] == []  # its server says so, no clock
    assert [r.n for r in records] == list(range(1, len(records) + 1))


@pytest.mark.soak
def test_a_changed_byte_is_named_and_refused(stopped):
    run, _ = stopped
    journal = run / "journal.jsonl"
    journal.write_bytes(journal.read_bytes().replace(b'"first"', b'"worst"'))
    ended = labrun("resume", run)

    assert ended.returncode == 2
    assert "the chain breaks at record" in ended.stderr
