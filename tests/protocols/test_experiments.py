"""Experiments that decide and watch: their results are right, and a killed one does nothing twice."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import pytest

from labrun.engine.check import check_file
from labrun.engine.journal.journal import read_records
from labrun.engine.rehearse.rehearse import Rehearsal
from labrun.web.demo.orders import order

pytestmark = pytest.mark.slow
PROTOCOLS = Path(str(files("labrun.protocols")))
COMMAND = [sys.executable, "-m", "labrun.engine"]
DEMO = Path(str(files("labrun.web.demo"))) / "twins.py"
NIGHT = f"""simulated: true
devices:
  furnace: {{contract: furnace@1, driver: '{DEMO}:Furnace', config: {{clock: 3600}}}}
  floor: {{contract: leak_sensor@1, driver: '{DEMO}:LeakSensor', config: {{clock: 3600MORE}}}}
"""
"""The furnace's night, an hour a second."""

PORTIONS = """labrun: 1
name: portions
devices: {balance: balance@1, pipette: pipette@1}
defaults: {timeout: 60 s}
steps:
  - {do: balance.zero}
  - {do: balance.tare}
  - {do: pipette.pick_up_tip}
  - foreach: {i: "${{ range(3) }}"}
    steps:
      - {id: before, do: balance.weigh}
      - {do: pipette.aspirate, with: {volume: 100 uL}}
      - {do: pipette.dispense, with: {volume: 100 uL}}
      - {wait: 3 s}
      - {id: after, do: balance.weigh}
    collect:
      above_tare: "${{ steps.after.mass }}"
      portion: "${{ steps.after.mass - steps.before.mass }}"
"""
"""Weighed before and after each portion: what was read before it cannot be read again."""


class Bench:
    """A folder in which a shipped protocol is run, killed and resumed, as a user would."""

    def __init__(self, folder):
        self.folder = folder
        self.told = ""

    def begin(self, name, *words):
        with (self.folder / "told.txt").open("w") as told:
            return subprocess.Popen(
                [*COMMAND, "run", str(PROTOCOLS / name), "--runs", "runs", *words],
                cwd=self.folder, stdout=told, stderr=subprocess.STDOUT,
            )  # fmt: skip

    def run(self, name, *words):
        engine = self.begin(name, *words)
        return self.over(engine.wait())

    def resume(self):
        went = subprocess.run(
            [*COMMAND, "resume", "last", "--runs", "runs"],
            cwd=self.folder, capture_output=True, text=True,
        )  # fmt: skip
        (self.folder / "told.txt").write_text(went.stdout + went.stderr)
        return self.over(went.returncode)

    def over(self, status):
        self.told = (self.folder / "told.txt").read_text()
        return status

    @property
    def of_run(self):
        (found,) = (self.folder / "runs").iterdir()
        return found

    def rows(self):
        with (self.of_run / "data.csv").open(newline="") as file:
            return list(csv.DictReader(file))

    @property
    def outputs(self):
        outputs = list(read_records(self.of_run / "journal.jsonl"))[-1].outputs
        return {n: v["$quantity"][0] if isinstance(v, dict) else v for n, v in outputs.items()}

    def truth(self, device, what):
        path = self.of_run / "servers" / "world" / "truth" / f"{device}.jsonl"
        lines = path.read_text().splitlines() if path.exists() else []
        return [entry for line in lines if (entry := json.loads(line))["what"] == what]

    def wait_for(self, device, what, count):
        until = time.monotonic() + 550
        while time.monotonic() < until:
            if any(self.folder.glob("runs/*")) and len(self.truth(device, what)) >= count:
                return
            time.sleep(0.05)
        raise AssertionError(f"{count} × {device}.{what} never came")


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)


def nothing_twice(entries):
    return max(Counter(entry["goal"].rpartition("/")[0] for entry in entries).values()) == 1


@pytest.mark.soak
def test_a_plate_is_filled_and_weighed_though_its_engine_is_killed_in_the_middle_of_a_column(bench):
    engine = bench.begin("fill_plate.yaml")
    bench.wait_for("pipette", "dispense", 20)
    engine.send_signal(signal.SIGKILL)
    engine.wait()

    assert bench.resume() == 0, bench.told
    drops = bench.truth("pipette", "dispense")
    masses = [float(row["mass_g"]) for row in bench.rows()]
    assert len(drops) == len(masses) == 96 and nothing_twice(drops)
    fallen = [drop["after"]["dropped_mg"] / 1000 for drop in drops]
    assert masses == pytest.approx(fallen, abs=0.004)
    assert fallen == pytest.approx([0.05 * n for n in range(1, 97)], rel=0.05)
    assert len(bench.truth("pipette", "eject_tip")) == 1


@pytest.mark.parametrize(
    "killed", ["server", pytest.param("server and engine", marks=pytest.mark.soak)]
)
def test_masses_are_right_though_the_server_of_the_balance_is_killed_with_liquid_on_the_pan(
    bench, killed
):
    protocol = bench.folder / "portions.yaml"
    protocol.write_text(PORTIONS)
    engine = bench.begin(protocol)
    bench.wait_for("pipette", "dispense", 2)
    server = json.loads((bench.of_run / "servers" / "balance" / "server.json").read_text())
    os.kill(server["pid"], signal.SIGKILL)
    if killed == "server":
        status = bench.over(engine.wait())
    else:
        engine.send_signal(signal.SIGKILL)
        engine.wait()
        status = bench.resume()

    assert status == 0, bench.told
    drops, rows = bench.truth("pipette", "dispense"), bench.rows()
    assert len(drops) == 3 and nothing_twice(drops)
    assert len(bench.truth("balance", "zero")) == len(bench.truth("balance", "tare")) == 1
    assert [float(row["above_tare_g"]) for row in rows] == pytest.approx([0.1, 0.2, 0.3], abs=0.01)
    assert [float(row["portion_g"]) for row in rows] == pytest.approx([0.1] * 3, abs=0.01)
    touched = [r for r in read_records(bench.of_run / "journal.jsonl") if r.kind == "touched"]
    assert "balance" in {r.device for r in touched}


def test_a_titration_finds_its_end_point_though_its_engine_is_killed_in_the_middle(bench):
    engine = bench.begin("titration.yaml")
    bench.wait_for("pump", "dose", 20)
    engine.send_signal(signal.SIGKILL)
    engine.wait()

    assert bench.resume() == 0, bench.told
    rows, doses = bench.rows(), bench.truth("pump", "dose")
    volumes = [float(row["volume_ml"]) for row in rows]
    ph = [float(row["ph"]) for row in rows]
    assert bench.outputs["end_point"] == pytest.approx(0.0783 * 20 / 0.1, abs=0.02)
    assert bench.outputs["concentration"] == pytest.approx(0.0783, rel=0.003)
    assert ph[0] < 4 and ph[-1] > 10.8 and len(bench.truth("pump", "fill")) > 1
    assert nothing_twice(doses) and len(doses) == len(rows) == bench.outputs["doses"]
    assert doses[-1]["after"]["dosed"] == pytest.approx(volumes[-1], abs=1e-3)
    steps = [b - a for a, b in pairwise(volumes)]
    near = [s for s, v in zip(steps, volumes, strict=False) if abs(v - 15.66) < 0.1]
    assert max(near) < 0.06 < 0.9 < max(steps)


@pytest.mark.soak
def test_a_furnace_that_is_killed_in_the_night_is_held_no_longer_than_was_wanted(bench):
    (bench.folder / "lab.yaml").write_text(NIGHT.replace("MORE", ""))
    engine = bench.begin("furnace_night.yaml", "--lab", "lab.yaml", "-p", "hold=3 h")
    bench.wait_for("furnace", "hold", 2)
    time.sleep(0.4)  # in the middle of it
    engine.send_signal(signal.SIGKILL)
    engine.wait()

    assert bench.resume() == 0, bench.told
    holds, rows = bench.truth("furnace", "hold"), bench.rows()
    assert nothing_twice(holds) and len(holds) == len(rows) == 3
    # At an hour a second; a row takes its time when its hold's outcome has come.
    assert 3 * 3600 - 60 < sum(float(row["held_s"]) for row in rows) < 3.3 * 3600
    assert all(845 < float(row["mean_°C"]) < 855 for row in rows)


@pytest.mark.parametrize("trouble", [pytest.param("leak", marks=pytest.mark.soak), "ordered"])
def test_what_is_watched_brings_the_furnace_down_in_order_and_tells(bench, trouble):
    more = (
        ", leak_after_s: 144000" if trouble == "leak" else ""
    )  # in the hold, however late that begins
    (bench.folder / "lab.yaml").write_text(NIGHT.replace("MORE", more))
    # Of sixty hours: there is time to see it, however slow the machine is.
    engine = bench.begin("furnace_night.yaml", "--lab", "lab.yaml", "-p", "hold=60 h")
    bench.wait_for("furnace", "hold", 1)
    words = "water on the floor: status.floor.wet (floor.wet is true)"
    if trouble == "ordered":
        order(bench.of_run / "servers" / "world", "furnace", "error", "hold", "SensorBroken", 1)
        words = "furnace.hold: hold: injected fault (demo) (fallback 1)"
    status = bench.over(engine.wait())

    ramps = bench.truth("furnace", "ramp")
    told = bench.told.index("were held"), bench.told.index("The furnace is off")
    assert status == 1 and words in bench.told, bench.told
    assert told[0] < told[1]
    assert ramps[0]["to"] == 850 and ramps[-1]["to"] == 300
    assert "/f1/" in ramps[-1]["goal"]
    assert bench.truth("furnace", "off")[0]["temperature_c"] == pytest.approx(305, abs=10)
    assert len(bench.rows()) < 60


@pytest.mark.soak
@pytest.mark.parametrize(
    ("trouble", "reason"),
    [
        ("leak_after_s: 7200", "water on the floor: status.floor.wet (floor.wet is true)"),
        (
            "breaks_after_s: 7200",
            "water on the floor: nobody knows whether status.floor.wet: nothing for 3",
        ),
    ],
)
def test_a_night_is_rehearsed_with_its_leak_and_with_a_sensor_that_falls_silent(
    tmp_path, trouble, reason
):
    lab = tmp_path / "lab.yaml"
    lab.write_text(NIGHT.replace("MORE", f", {trouble}"))
    totals = Rehearsal(check_file(PROTOCOLS / "furnace_night.yaml", lab=lab), {}).play()

    assert totals.fate == "failed" and totals.reason.startswith(reason)
    assert 3 * 3600 < totals.lasts_s < 5 * 3600
    assert totals.actions == {"furnace.ramp": 2, "furnace.off": 2}


@pytest.mark.soak
def test_a_raster_is_in_focus_at_every_point_though_the_sample_lies_askew(bench):
    assert bench.run("autofocus_raster.yaml") == 0, bench.told
    rows, looks = bench.rows(), bench.truth("microscope", "look")
    off_mm = {
        look["goal"].split("/")[3]: look["off_mm"] for look in looks
    }  # the last of each point

    assert len(rows) == len(off_mm) == 28
    assert max(map(abs, off_mm.values())) < 0.14  # of a bell of 0.12 mm: blurred below 60 %
    assert 4 < bench.outputs["focused"] < 14
    focused = {row["z_mm"]: row for row in reversed(rows)}.values()
    for row in focused:
        true_mm = 20 + 0.02 * float(row["x_mm"]) + 0.01 * float(row["y_mm"])
        assert float(row["z_mm"]) == pytest.approx(true_mm, abs=0.02)


@pytest.mark.soak
def test_a_plate_recovers_the_calibration_and_the_samples_that_it_was_given(bench):
    assert bench.run("plate_96.yaml", "-p", "develop=1 s") == 0, bench.told
    (table,) = (path for path in bench.of_run.glob("data-*.csv"))
    with table.open(newline="") as file:
        samples = list(csv.DictReader(file))
    reliable = [row for row in samples if row["reliable"] == "True"]
    column = next(name for name in samples[0] if name.startswith("concentration"))

    # 10 a cm of the stock of 200 umol/L, 0.2 mL over 0.34 cm²; the plate itself absorbs 0.04
    assert bench.outputs["slope"] == pytest.approx(10 * 0.2 / 0.34 / 200, rel=0.02)
    assert bench.outputs["blank"] == pytest.approx(0.04, abs=0.01)
    assert len(bench.rows()) == 24 and len(samples) == 72 and len(reliable) == 72
    for row in samples:  # the sample absorbs as 80 umol/L do
        expected = 80 * float(row["sample_ul"]) / 200
        assert float(row[column]) == pytest.approx(expected, rel=0.03, abs=1.5)
    doses = bench.truth("dispenser", "dispense")
    assert nothing_twice(doses) and len({dose["into"] for dose in doses}) == 96
    rows = [dose["into"][0] for dose in doses if dose["into"][0] not in "AH"]
    assert sum(a != b for a, b in pairwise(rows)) == 5  # no row is filled in pieces
