"""The shipped protocols deliver what they promise: rows, outputs and figures on the simulated lab."""

import csv
import json
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from contextlib import closing
from importlib.resources import files
from pathlib import Path

import pytest

from labrun.drivers.simulated.twins.instrument import OFFSETS_NM
from labrun.drivers.simulated.twins.minerals import atom_fractions
from labrun.engine.journal.journal import read_records

PROTOCOLS = Path(str(files("labrun.protocols")))


class Ran:
    """One run of a shipped protocol, as a user would run it, and what it left behind."""

    def __init__(self, folder, name, *words):
        self.done = subprocess.run(
            [sys.executable, "-m", "labrun.engine", "run", str(PROTOCOLS / name), *words],
            cwd=folder, capture_output=True, text=True,
        )  # fmt: skip
        (self.folder,) = (folder / "runs").iterdir()
        self.told = self.done.stdout + self.done.stderr
        self.records = list(read_records(self.folder / "journal.jsonl"))

    @property
    def outputs(self):
        assert self.done.returncode == 0, self.told
        return {name: magnitude(value) for name, value in self.records[-1].outputs.items()}

    def rows(self, name="data.csv"):
        with (self.folder / name).open(newline="") as file:
            return list(csv.DictReader(file))

    def truth(self, device, what):
        path = self.folder / "servers" / "world" / "truth" / f"{device}.jsonl"
        entries = [json.loads(line) for line in path.read_text().splitlines()]
        return [entry for entry in entries if entry["what"] == what]


def magnitude(value):
    """A quantity as stored in the journal, without its unit."""
    return value["$quantity"][0] if isinstance(value, dict) else value


def numbers(rows, column):
    return [float(row[column]) for row in rows]


@pytest.mark.soak
def test_a_calibrated_map_ends_in_weight_per_cent_and_keeps_its_calibration(tmp_path):
    ran = Ran(tmp_path, "calibrated_map.yaml", "-p", "pitch=1 mm", "-p", "every=4")
    rows, checks = ran.rows(), ran.rows("data-scan-1-then-check.csv")
    mineral = {
        shot["goal"].split("/")[3]: shot["mineral"]
        for shot in ran.truth("libs", "shot")
        if "/shoot/" in shot["goal"]
    }

    assert ran.outputs == {} and len(rows) == 9
    for row in rows:
        if mineral[row["key"]] == "spodumene":
            assert 2 < float(row["Li_wt_percent"]) < 5.5
        else:  # some at the edge of a grain
            assert row["Li_wt_percent_flags"] == "below LOD" or float(row["Li_wt_percent"]) < 1
    assert [row["point"] for row in checks] == ["0", "4", "8"]
    assert all(2 < float(row["Li_wt_percent"]) < 5.5 for row in checks)
    assert (ran.folder / "concentrations.png").stat().st_size > 10_000
    kept = (ran.folder / "used" / "1-simulated.calibration").read_bytes()
    assert kept == (PROTOCOLS / "simulated.calibration").read_bytes()


@pytest.mark.soak
def test_multi_sample_maps_every_core_of_its_table(tmp_path):
    ran = Ran(tmp_path, "multi_sample.yaml")
    cores, points = ran.rows(), ran.rows("data-cores-scan-scan.csv")

    assert ran.outputs == {"cores": 3, "failed": 0}
    assert [(row["sample"], row["points"]) for row in cores] == [
        ("SPD-01", "6"), ("SPD-02", "4"), ("QTZ-07", "6"),
    ]  # fmt: skip
    assert Counter(row["sample"] for row in points) == {"SPD-01": 6, "SPD-02": 4, "QTZ-07": 6}
    for core in cores:
        own = [row for row in points if row["sample"] == core["sample"]]
        assert float(core["most_li"]) == max(numbers(own, "Li"))
        assert next(r["key"] for r in own if r["Li"] == core["most_li"]).endswith(core["richest"])
    assert len(list((ran.folder / "spectra").glob("*.csv"))) == 16
    places = {(shot["x"], shot["y"]) for shot in ran.truth("libs", "shot")}
    assert len(places) == 16
    for core in cores:
        assert (ran.folder / f"element_maps_{core['sample']}.png").stat().st_size > 10_000


@pytest.mark.soak
def test_refine_map_is_fine_where_there_is_lithium_and_only_there(tmp_path):
    ran = Ran(tmp_path, "refine_map.yaml")
    rows = ran.rows()
    rich = [row for row in rows if float(row["Li"]) > 300]

    assert Counter(numbers(rows, "pitch_mm")).keys() == {2.0, 1.0, 0.5}
    assert len({(row["x_mm"], row["y_mm"]) for row in rows}) == len(rows) < 64
    for pitch in (2.0, 1.0):
        cut = sum(float(row["pitch_mm"]) == pitch for row in rich)
        assert numbers(rows, "pitch_mm").count(pitch / 2) == 4 * cut
    for row in rows:
        if float(row["pitch_mm"]) < 2:
            assert any(is_quarter(row, cell) for cell in rich)
    assert ran.outputs == {"rounds": 3, "measured": len(rows), "instead_of": 64, "finest": 0.5}
    seen = {row["mineral"] for row in ran.truth("libs", "shot")}
    assert any(atom_fractions(mineral).get("Li") for mineral in seen)
    assert (ran.folder / "element_maps.png").exists()


def is_quarter(row, cell):
    pitch = float(row["pitch_mm"])
    away = [abs(float(row[axis]) - float(cell[axis])) for axis in ("x_mm", "y_mm")]
    return float(cell["pitch_mm"]) == 2 * pitch and away == pytest.approx([pitch / 2] * 2)


@pytest.mark.soak
@pytest.mark.posix("SIGKILL")
def test_adaptive_map_goes_on_after_a_kill_and_tells_every_shot_once(tmp_path):
    words = [sys.executable, "-m", "labrun.engine"]
    size = ["-p", "width=2 mm", "-p", "height=2 mm", "-p", "shots=10", "-p", "batch=5"]
    run = [*words, "run", str(PROTOCOLS / "adaptive_map.yaml"), *size]
    engine = subprocess.Popen(run, cwd=tmp_path, stdout=subprocess.DEVNULL)
    until = time.monotonic() + 300
    while not any(len(p.read_text().splitlines()) > 6 for p in tmp_path.glob("runs/*/data.csv")):
        assert engine.poll() is None and time.monotonic() < until
        time.sleep(0.01)
    engine.kill()
    engine.wait()

    resumed = subprocess.run(
        [*words, "resume", "last"], cwd=tmp_path, capture_output=True, text=True
    )
    (folder,) = (tmp_path / "runs").iterdir()
    with (folder / "data.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    (log,) = folder.rglob("studies.sqlite")
    with closing(sqlite3.connect(log)) as disk:
        tells = disk.execute("SELECT said FROM lines WHERE what = 'tell'").fetchall()
        asked = disk.execute("SELECT said FROM lines WHERE what = 'ask'").fetchall()

    assert resumed.returncode == 0, resumed.stdout + resumed.stderr
    assert len({(row["x_mm"], row["y_mm"]) for row in rows}) == len(rows) == 10
    assert len({str(json.loads(said)["at"]) for (said,) in tells}) == len(tells) == 10
    assert [len(json.loads(said)) for (said,) in asked] == [5, 5]
    assert (folder / "element_maps.png").exists()


@pytest.mark.soak
def test_colour_mix_fills_a_well_for_each_suggestion_and_tells_the_best(tmp_path):
    ran = Ran(tmp_path, "colour_mix.yaml", "-p", "wells=9", "-p", "near=0")
    rows = ran.rows()
    filled = Counter(entry["into"] for entry in ran.truth("dispenser", "dispense"))

    assert [row["well"] for row in rows] == [*(f"{row}1" for row in "ABCDEFGH"), "A2"]
    assert set(filled) == {row["well"] for row in rows} and max(filled.values()) <= 4
    assert ran.outputs["away"] == pytest.approx(min(numbers(rows, "away")))
    for row in rows:
        assert sum(float(row[dye]) for dye in ("red", "yellow", "blue")) <= 100


@pytest.mark.soak
def test_calibrate_camera_finds_where_the_camera_sits_beside_the_tool(tmp_path):
    ran = Ran(tmp_path, "calibrate_camera.yaml")
    outputs = ran.outputs

    assert outputs["looks"] == len(ran.rows()) == 6
    assert outputs["rms"] == max(numbers(ran.rows(), "rms_pixel")) < 0.3
    found = [outputs[f"offset_{axis}"] for axis in "xyz"]
    assert found == pytest.approx([60, 40, 400], abs=1)
    assert outputs["tilt"] == pytest.approx(30, abs=0.3)
    assert outputs["apart"] < 1
    for name in ("board.png", "board_depth.png"):
        assert (ran.folder / name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.soak
def test_calibrate_camera_fails_where_the_offsets_lie_too_far_apart(tmp_path):
    ran = Ran(tmp_path, "calibrate_camera.yaml", "-p", "spread=1 um")

    assert ran.done.returncode == 1
    assert "apart <= params.spread is not true" in ran.told


@pytest.mark.soak
def test_find_and_scan_finds_the_core_and_fires_at_nothing_else(tmp_path):
    ran = Ran(tmp_path, "find_and_scan.yaml", "-p", "pitch=8 mm")
    outputs, shots = ran.outputs, ran.truth("libs", "shot")

    assert (outputs["x"], outputs["y"]) == pytest.approx((24, 60), abs=1)  # the core is 48 x 120 mm
    assert outputs["area"] == pytest.approx(48 * 120, rel=0.03)
    assert outputs["points"] == len(ran.rows()) == len(shots) > 5 * 13
    assert outputs["holes"] == 0
    assert min(shot["focus"] for shot in shots) > 0.99
    for axis, size in (("x", 48), ("y", 120)):
        at = [shot[axis] for shot in shots]
        assert min(at) > 1 and max(at) < size - 1  # of a margin of 3 mm
        assert max(at) - min(at) > size - 6 - 8 - 3
    assert (ran.folder / "bench.png").read_bytes().startswith(b"\x89PNG")
    assert (ran.folder / "element_maps.png").stat().st_size > 10_000


@pytest.mark.soak
def test_find_and_scan_fires_nowhere_where_there_is_no_core(tmp_path):
    ran = Ran(tmp_path, "find_and_scan.yaml", "-p", "smallest=9000 mm**2")

    assert ran.done.returncode == 1
    assert "There is no sample on the bench." in ran.told
    assert not (ran.folder / "data.csv").exists()


@pytest.mark.slow
def test_weigh_and_dispense_reaches_its_target_within_the_tolerance(tmp_path):
    ran = Ran(tmp_path, "weigh_and_dispense.json")
    outputs, rows = ran.outputs, ran.rows()

    assert outputs["mass"] == pytest.approx(1, abs=0.002)
    assert outputs["strokes"] == len(rows) > 1
    assert outputs["drawn"] == pytest.approx(sum(numbers(rows, "dose_ul")), abs=0.01)
    assert outputs["worst_stroke"] == pytest.approx(max(map(abs, numbers(rows, "off_g"))), abs=1e-4)
    assert outputs["gravimetric_factor"] == pytest.approx(1, abs=0.03)
    dropped = ran.truth("pipette", "dispense")[-1]["after"]["dropped_mg"]
    assert dropped == pytest.approx(1000, abs=4)
    assert ran.truth("pipette", "eject_tip")


@pytest.mark.soak
def test_wavelength_check_tells_the_offsets_that_the_simulated_detectors_were_given(tmp_path):
    ran = Ran(tmp_path, "wavelength_check.yaml")
    outputs = ran.outputs

    assert len(ran.rows()) == len(ran.truth("libs", "shot")) == 3
    assert [outputs[name] for name in ("ultraviolet", "visible", "red")] == pytest.approx(
        OFFSETS_NM, abs=0.004
    )
    assert sum(numbers(ran.rows(), "Li_off_nm")) / 3 == pytest.approx(outputs["red"], abs=1e-4)


@pytest.mark.soak
@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["tolerance=0.005 nm"], "The wavelengths are off: ultraviolet "),
        pytest.param(
            ["x=2.6 mm"],
            "does not show Si I 288.16, Al I 396.15 and Li I 670.78 nm",
            marks=pytest.mark.soak,
        ),
    ],
)
def test_wavelength_check_fails_with_a_sentence(tmp_path, words, sentence):
    ran = Ran(tmp_path, "wavelength_check.yaml", "-p", words[0], "-p", "shots=1")

    assert ran.done.returncode == 1
    assert sentence in ran.told


@pytest.mark.soak
def test_two_stations_fire_at_the_same_time_each_at_its_own_core(tmp_path):
    ran = Ran(tmp_path, "two_station.yaml")
    first, second = (ran.truth(device, "shot") for device in ("libs", "libs_b"))
    tables = [ran.rows(path.name) for path in sorted(ran.folder.glob("data*.csv"))]

    assert ran.outputs == {"first": 4, "second": 4}
    assert [[shot["x"] for shot in shots] for shots in (first, second)] == [
        pytest.approx([0, 1, 2, 3], abs=0.006)
    ] * 2
    assert [len(table) for table in tables] == [4, 4]
    assert [shot["mineral"] for shot in first] != [shot["mineral"] for shot in second]
    assert first[0]["at"] < second[-1]["at"] and second[0]["at"] < first[-1]["at"]
    assert len(list((ran.folder / "spectra").glob("*.csv"))) == 8
