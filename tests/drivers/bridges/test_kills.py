"""Engines and device servers are killed in the middle of runs; the instrument's own file judges."""

import collections
import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest

from labrun.engine.journal.journal import read_records

POINTS = 24
SCPI = {
    "timeout": "8 s",
    "actions": {
        "count": {"query": "COUN?", "returns": {"count": {"type": "integer"}}},
        "dispense": {
            "write": "DISP {volume:.1f} {goal}", "wait": True, "count": "count",
            "params": {"volume": {"unit": "uL"}},
        },
    },
}  # fmt: skip
TEXT = {
    "timeout": "8 s",
    "actions": {
        "count": {
            "send": "COUN?", "effect": "pure", "answer": r"(\d+)",
            "returns": {"count": {"type": "integer"}},
        },
        "dispense": {
            "send": ["DISP {volume:.1f} {goal}", "*OPC?"], "answer": "1", "count": "count",
            "params": {"volume": {"unit": "uL"}},
        },
    },
}  # fmt: skip
MODBUS = {
    "poll": 0.05,
    "registers": {"start": {"coil": 0}, "doses": {"input": 1}, "busy": {"input": 2}},
    "actions": {
        "count": {"read": "doses", "returns": {"doses": {"type": "integer"}}},
        "state": {"read": "busy", "returns": {"busy": {"type": "boolean"}}},
        "dispense": {
            "write": {"start": True}, "until": {"do": "state", "busy": False}, "count": "count",
            "params": {"volume": {"unit": "uL"}},
        },
    },
}  # fmt: skip
HTTP = {
    "poll": 0.05,
    "actions": {
        "count": {"get": "/state", "returns": {"count": {"type": "integer", "at": "data.count"}}},
        "state": {"get": "/state", "returns": {"busy": {"type": "boolean", "at": "data.busy"}}},
        "dispense": {
            "post": "/shake", "body": {"goal": "{volume:.1f} {goal}"}, "count": "count",
            "until": {"do": "state", "busy": False}, "params": {"volume": {"unit": "uL"}},
        },
    },
}  # fmt: skip
PROTOCOL = {
    "labrun": 1,
    "name": "portions",
    "devices": {"pump": "pump@1"},
    "steps": [
        {
            "foreach": {"n": f"${{{{ span(1, {POINTS}, 1) }}}}"},
            "key": "${{ n }}",
            "steps": [{"do": "pump.dispense", "with": {"volume": "${{ n * 1 uL }}"}}],
        }
    ],
}


def engine(*words, log):
    with log.open("ab") as out:
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "labrun.engine", *words], stdin=subprocess.DEVNULL,
            stdout=out, stderr=out, start_new_session=True,
        )  # fmt: skip


def kill_server(run):
    """kill -9, as the run's own file says who it is."""
    with contextlib.suppress(OSError, ValueError, ProcessLookupError):
        words = json.loads((run / "servers" / "pump" / "server.json").read_text("utf-8"))
        os.kill(words["pid"], signal.SIGKILL)


def soak(*values):
    """Of six ways to reach an instrument two are killed on every change."""
    return pytest.param(*values, marks=pytest.mark.soak)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("driver", "config", "program", "over", "seed"),
    [
        ("scpi", SCPI, "line_peer.py", "tcp", 1),
        soak("scpi", SCPI, "line_peer.py", "pty", 2),
        soak("text", TEXT, "line_peer.py", "tcp", 3),
        soak("text", TEXT, "line_peer.py", "udp", 4),
        soak("modbus", MODBUS, "modbus_peer.py", "", 5),
        soak("http", HTTP, "http_peer.py", "", 6),
    ],
)
def test_no_portion_is_dispensed_twice_or_left_out(
    tmp_path, peer, driver, config, program, over, seed
):
    there = peer(program, over=over, work_s=0.15)
    where = {"url" if driver == "http" else "resource": there.where}
    device = {"driver": driver, "config": {**where, **config}}
    (tmp_path / "lab.yaml").write_text(json.dumps({"devices": {"pump": device}}), "utf-8")
    (tmp_path / "portions.json").write_text(json.dumps(PROTOCOL), "utf-8")
    log, runs, draws = tmp_path / "engine.log", tmp_path / "runs", random.Random(seed)
    words = [
        "run",
        str(tmp_path / "portions.json"),
        "--lab",
        str(tmp_path / "lab.yaml"),
        "--runs",
        str(runs),
    ]
    kills, until = 0, time.monotonic() + 240
    while time.monotonic() < until:
        process = engine(*words, log=log)
        seen = len(there.done("dispense"))
        while process.poll() is None and kills < 6:  # killed after some more portions, in one
            if len(there.done("dispense")) >= seen + 2:
                time.sleep(draws.uniform(0, 0.2))
                run = next(runs.iterdir())
                if draws.random() < 0.7:
                    kill_server(run)
                if draws.random() < 0.7:
                    process.kill()
                kills += 1
                seen = len(there.done("dispense"))
            time.sleep(0.01)
        process.wait(240)
        run = next(runs.iterdir())
        last = list(read_records(run / "journal.jsonl"))[-1]
        if last.kind == "finished":
            break
        words = ["resume", str(run)]

    given = [one.get("given", "").partition(" ")[0] for one in there.done("dispense")]
    told = log.read_text("utf-8", errors="replace")[-3000:]

    assert last.fate == "succeeded", told
    assert len(given) == POINTS, told
    if driver != "modbus":  # its coil does not say for whom
        assert collections.Counter(given) == {f"{n:.1f}": 1 for n in range(1, POINTS + 1)}, told
    assert kills >= 3
