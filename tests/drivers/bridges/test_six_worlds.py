"""One protocol that uses six worlds at once, while servers and the engine are killed and cables are cut.

Each instrument is a process of its own that writes down what it really did and outlives everybody; only
PyLabRobot's backend lives in its driver's process, and its file outlives that. What came of it is in
`docs/how-to/instruments-in-yaml.md`. `SIX_WORLDS_POINTS=40 SIX_WORLDS_SEED=2` choose another run.
"""

import collections
import contextlib
import json
import os
import random
import signal
import socket
import time
import warnings
from contextlib import ExitStack

import pytest

from labrun.engine.journal.journal import read_records

from .cut_cable import cable
from .instruments import PEERS, running_peer
from .test_kills import engine

pytestmark = [
    pytest.mark.soak,
    pytest.mark.needs("pymeasure", "ophyd", "pylabrobot", "sila2"),
    pytest.mark.filterwarnings("default"),  # what the libraries warn of is their own matter
]
POINTS = int(os.environ.get("SIX_WORLDS_POINTS", "12"))
SEED = int(os.environ.get("SIX_WORLDS_SEED", "1"))
ONCE = {
    "meter": "dispense", "furnace": "dispense", "source": "trigger", "handler": "dispense",
    "shaker": "dispense",
}  # fmt: skip
"""Device -> what its peer writes down for the `once` action of a point."""
MOST_KILLS = 4
INTEGER = {"type": "integer"}
METER = {
    "timeout": "8 s",
    "actions": {
        "count": {"query": "COUN?", "returns": {"count": INTEGER}},
        "portion": {
            "write": "DISP {n} {goal}", "wait": True, "count": "count", "params": {"n": INTEGER},
        },
    },
}  # fmt: skip
FURNACE = {
    "poll": 0.05,
    "registers": {
        "start": {"coil": 0}, "doses": {"input": 1}, "busy": {"input": 2},
        "target": {"holding": 10, "type": "int16", "scale": 0.1},
    },
    "actions": {
        "count": {"read": "doses", "returns": {"doses": INTEGER}},
        "state": {"read": "busy", "returns": {"busy": {"type": "boolean"}}},
        "heat": {
            "write": {"target": "{to}"}, "params": {"to": {"unit": "degC"}}, "effect": "idempotent",
        },
        "dose": {
            "write": {"start": True}, "until": {"do": "state", "busy": False}, "count": "count",
            "timeout": "8 s",
        },
    },
}  # fmt: skip
SOURCE = {
    "instrument": "keithley.Keithley2400",
    "options": {"read_termination": "\n", "write_termination": "\n"},
    "timeout": "8 s",
    "actions": {
        "points": {
            "call": "ask", "effect": "pure", "returns": {"points": INTEGER},
            "params": {"command": {"type": "string", "default": ":TRACE:POINTS:ACTUAL?"}},
        },
        "set_voltage": {
            "set": "source_voltage", "params": {"to": {"unit": "V"}}, "effect": "idempotent",
        },
        "trigger": {"call": "trigger", "count": "points"},
    },
}  # fmt: skip
MOTOR = {
    "instrument": "ophyd.EpicsMotor",
    "prefix": "bench:m1",
    "timeout": "20 s",
    "actions": {
        "move": {"call": "set", "params": {"new_position": {"unit": "mm"}}, "effect": "idempotent"},
        "stop": {"call": "stop", "effect": "idempotent"},
    },
}
HANDLER = {
    "instrument": "liquid_handling.LiquidHandler",
    "backend": "handler_backend.Written",
    "timeout": "20 s",
    "actions": {
        "picked": {"get": "backend.picked", "returns": {"picked": INTEGER}},
        "dispensed": {"get": "backend.dispensed", "returns": {"dispensed": INTEGER}},
        "pick_up": {
            "call": "pick_up_tips", "count": "picked",
            "params": {"tip_spots": {"type": "array", "items": {"type": "string", "format": "resource"}}},
        },
        "transfer": {
            "call": "transfer", "count": "dispensed",
            "params": {
                "source": {"type": "string", "format": "resource"},
                "targets": {"type": "array", "items": {"type": "string", "format": "resource"}},
                "source_vol": {"unit": "uL"},
            },
        },
    },
}  # fmt: skip
SHAKER = {
    "insecure": True,
    "timeout": "8 s",
    "actions": {
        "count": {"get": "Shaking.Count", "returns": {"count": INTEGER}},
        "shake": {
            "call": "Shaking.Shake", "count": "count", "params": {"label": {"type": "string"}},
        },
    },
}  # fmt: skip
CONFIGS = {
    "meter": ("scpi", METER), "furnace": ("modbus", FURNACE), "source": ("pymeasure", SOURCE),
    "motor": ("ophyd", MOTOR), "handler": ("pylabrobot", HANDLER), "shaker": ("sila2", SHAKER),
}  # fmt: skip
AGAIN = {"attempts": 8, "wait": "0.2 s"}
AT_ONCE = [
    {"do": "meter.portion", "with": {"n": "${{ n }}"}, "retry": AGAIN},
    {"do": "furnace.dose", "retry": AGAIN},
    {"do": "source.trigger", "retry": AGAIN},
    {
        "do": "handler.transfer", "retry": AGAIN,
        "with": {"source": "plate.A1", "targets": ["plate.H12"], "source_vol": "20 uL"},
    },
    {"do": "shaker.shake", "with": {"label": "portion ${{ n }}"}, "retry": AGAIN},
]  # fmt: skip
PROTOCOL = {
    "labrun": 1,
    "name": "six_worlds",
    "devices": {name: f"{name}@1" for name in CONFIGS},
    "steps": [
        {"do": "handler.pick_up", "with": {"tip_spots": ["tips.A1"]}, "retry": AGAIN},
        {
            "foreach": {"n": f"${{{{ span(1, {POINTS}, 1) }}}}"},
            "key": "${{ n }}",
            "steps": [
                {
                    "parallel": [
                        {"do": "motor.move", "with": {"new_position": "${{ n * 1 mm }}"}, "retry": AGAIN},
                        {"do": "furnace.heat", "with": {"to": "${{ (n + 300) * 1 K }}"}, "retry": AGAIN},
                        {"do": "source.set_voltage", "with": {"to": "${{ n * 0.1 V }}"}, "retry": AGAIN},
                    ]
                },
                {"parallel": AT_ONCE},
            ],
        },
    ],
}  # fmt: skip


def deck(path):
    """Tips and a plate."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from pylabrobot.resources import (
            PLT_CAR_L5AC_A00,
            TIP_CAR_480_A00,
            cor_96_wellplate_360uL_Fb,
            hamilton_96_tiprack_1000uL_filter,
        )
        from pylabrobot.resources.hamilton import STARLetDeck

        made, tips, plates = STARLetDeck(), TIP_CAR_480_A00(name="a"), PLT_CAR_L5AC_A00(name="b")
        tips[0] = hamilton_96_tiprack_1000uL_filter(name="tips")
        plates[0] = cor_96_wellplate_360uL_Fb(name="plate")
        made.assign_child_resource(tips, rails=3)
        made.assign_child_resource(plates, rails=15)
        made.save(str(path))


def kill(run, device, killed):
    """kill -9, as the server's own file says who it is; False if it does not run.

    An engine gives up a server that has died five times, and goes on without it.
    """
    if killed[device] >= MOST_KILLS:
        return False
    with contextlib.suppress(OSError, ValueError, ProcessLookupError):
        words = json.loads((run / "servers" / device / "server.json").read_text("utf-8"))
        os.kill(words["pid"], signal.SIGKILL)
        killed[device] += 1
        return True
    return False


def free_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return str(free.getsockname()[1])


def lines_of(path):
    if not path.exists():
        return []
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """Peers that run, cables to those with TCP, and the lab."""
    pytest.importorskip("caproto")
    port = free_port()
    for name, value in {
        "EPICS_CA_SERVER_PORT": port, "EPICS_CA_ADDR_LIST": "127.0.0.1",
        "EPICS_CA_AUTO_ADDR_LIST": "NO", "HANDLER_FILE": str(tmp_path / "handler" / "done.jsonl"),
        "HANDLER_WORK_S": "0.15", "GRPC_VERBOSITY": "NONE",
        "PYTHONPATH": os.pathsep.join([str(PEERS), os.environ.get("PYTHONPATH", "")]),
    }.items():  # fmt: skip
        monkeypatch.setenv(name, value)
    programs = {
        "meter": "line_peer.py", "furnace": "modbus_peer.py", "source": "source_meter_peer.py",
        "motor": "motor_peer.py", "shaker": "sila_peer.py",
    }  # fmt: skip
    (tmp_path / "handler").mkdir()
    deck(tmp_path / "handler" / "deck.json")
    with ExitStack() as stack:
        peers, cables, devices = {}, {}, {}
        for name, (driver, config) in CONFIGS.items():
            more = {}
            if name in programs:
                there = running_peer(tmp_path / name, programs[name], work_s=0.15)
                peers[name] = stack.enter_context(there)
            if name in ("meter", "furnace", "source", "shaker"):
                at = peers[name].where.removeprefix("sila2://")
                cables[name] = stack.enter_context(cable(at))
                host, _, number = cables[name].where.rpartition(":")
                more = {
                    "meter": {"resource": cables[name].where},
                    "furnace": {"resource": cables[name].where},
                    "source": {"resource": f"TCPIP::{host}::{number}::SOCKET"},
                    "shaker": {"url": f"sila2://{cables[name].where}"},
                }[name]
            if name == "handler":
                more = {"deck": str(tmp_path / "handler" / "deck.json")}
            devices[name] = {"driver": driver, "config": {**config, **more}}
        (tmp_path / "lab.yaml").write_text(
            json.dumps({"start_timeout": "2 min", "devices": devices}), "utf-8"
        )
        yield tmp_path, cables


def test_six_worlds_at_once_lose_nothing_and_do_nothing_twice(bench):
    folder, cables = bench
    (folder / "six_worlds.json").write_text(json.dumps(PROTOCOL), "utf-8")
    log, runs, draws = folder / "engine.log", folder / "runs", random.Random(SEED)
    words = ["run", str(folder / "six_worlds.json"), "--lab", str(folder / "lab.yaml")]
    words += ["--runs", str(runs)]
    told, until, next_at = collections.Counter(), time.monotonic() + 3000, 2
    last, gave_up = None, 0
    while time.monotonic() < until and gave_up < 3:
        process, killed = engine(*words, log=log), collections.Counter()
        while process.poll() is None:
            made = len(lines_of(folder / "meter" / "done.jsonl")) - 1
            if made >= next_at and made < POINTS - 1:
                time.sleep(draws.uniform(0, 0.3))
                run = next(runs.iterdir())
                match draws.choice(["server", "servers", "engine", "cut", "cuts", "all"]):
                    case "server":
                        told["servers killed"] += kill(run, draws.choice(list(CONFIGS)), killed)
                    case "servers":
                        told["servers killed"] += sum(kill(run, name, killed) for name in CONFIGS)
                    case "engine":
                        process.kill()
                        told["engines killed"] += 1
                    case "cut":
                        told["cables cut"] += draws.choice(list(cables.values())).cut()
                    case "cuts":
                        told["cables cut"] += sum(one.cut() for one in cables.values())
                    case "all":
                        told["cables cut"] += sum(one.cut() for one in cables.values())
                        told["servers killed"] += sum(kill(run, name, killed) for name in CONFIGS)
                        process.kill()
                        told["engines killed"] += 1
                told["moments"] += 1
                next_at = made + draws.randint(1, 3)
            time.sleep(0.01)
        process.wait(240)
        run = next(runs.iterdir())
        last = list(read_records(run / "journal.jsonl"))[-1]
        if last.kind == "finished":
            break
        gave_up += process.returncode > 0  # nobody has killed it
        words = ["resume", str(run)]
    done = {name: lines_of(folder / name / "done.jsonl") for name in CONFIGS}
    counts = {name: sum(one["done"] == what for one in done[name]) for name, what in ONCE.items()}
    moved = [one["to"] for one in done["motor"] if one["done"] == "move"]
    said = log.read_text("utf-8", errors="replace")[-4000:]
    print(json.dumps({"points": POINTS, "seed": SEED, **told, "done": counts, "moves": len(moved)}))

    assert last is not None and last.fate == "succeeded", said
    assert counts == dict.fromkeys(ONCE, POINTS), said
    given = [one["given"].partition(" ")[0] for one in done["meter"] if one["done"] == "dispense"]
    assert sorted(given, key=float) == [f"{n}" for n in range(1, POINTS + 1)], said
    assert list(dict.fromkeys(moved)) == [float(n) for n in range(1, POINTS + 1)], said
    assert told["moments"] >= 3
