"""The whole map with an analyser that fails sometimes and dies once: it completes by itself."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from importlib.resources import files
from pathlib import Path

import pytest

from labrun.engine.journal.course import split_goal_id
from labrun.engine.journal.journal import read_records

pytestmark = pytest.mark.soak


PEGMATITE = Path(str(files("labrun.protocols").joinpath("pegmatite_map.yaml")))
ATTEMPTS = 3  # the protocol's retry of a shot
LAB = """name: faulty
simulated: true
devices:
  gantry: {contract: gantry@1, driver: sim_gantry, config: {clock: fast, homed: true}}
  libs:
    contract: libs_analyzer@1
    driver: sim_libs
    config:
      clock: fast
      gantry: gantry
      faults: {measure: {ButtonNotFound: 0.01, DialogOpen: 0.01}, export: 0.01}
  reduce: {contract: spectrum_reducer@1, driver: reducer}
"""


@pytest.mark.parametrize(("pitch", "points"), [("1 mm", 55), ("0.2 mm", 1071)])
@pytest.mark.timeout(600)
def test_a_scan_with_faults_and_a_restart_ends_by_itself_complete(tmp_path, pitch, points):
    (tmp_path / "lab.yaml").write_text(LAB)
    process = subprocess.Popen(
        [sys.executable, "-m", "labrun.engine", "run", str(PEGMATITE), "--lab", "lab.yaml",
         "-p", f"pitch={pitch}"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    run = kill_the_analyser_after(tmp_path, points // 2)
    told, _ = process.communicate()

    with (run / "data.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    log = run / "servers" / "world" / "truth" / "libs.jsonl"
    shots = [json.loads(line) for line in log.read_text().splitlines()]
    records = list(read_records(run / "journal.jsonl"))
    errors = Counter(r.error.name for r in records if r.kind == "ended" and r.error)

    assert process.returncode == 0, told
    assert [row["fate"] for row in rows] == ["succeeded"] * points
    assert len({row["key"] for row in rows}) == points
    assert all(row["Li"] for row in rows)
    assert all((run / f"spectra/core_{row['key'].replace(',', '_')}.csv").exists() for row in rows)
    assert max(Counter(shot["goal"] for shot in shots).values()) == 1
    assert max(Counter(split_goal_id(shot["goal"])[0] for shot in shots).values()) == 1
    tries = Counter(
        split_goal_id(r.id)[0] for r in records if r.kind == "goal" and r.action == "measure"
    )
    assert max(tries.values()) <= ATTEMPTS
    assert min(shot["focus"] for shot in shots) > 0.99
    assert records[-1].outputs == {"points": points, "holes": 0}
    assert [r.device for r in records if r.kind == "touched"] == ["libs"]
    if points > 1000:
        assert errors["ButtonNotFound"] and errors["DialogOpen"] and errors["DiskFull"]


def kill_the_analyser_after(folder, rows):
    until = time.monotonic() + 300
    while time.monotonic() < until:
        found = list((folder / "runs").glob("*/data.csv")) if (folder / "runs").exists() else []
        if found and len(found[0].read_text().splitlines()) > rows:
            run = found[0].parent
            server = json.loads((run / "servers" / "libs" / "server.json").read_text())
            os.kill(server["pid"], signal.SIGKILL)
            return run
        time.sleep(0.02)
    raise AssertionError(f"{rows} rows never came")
