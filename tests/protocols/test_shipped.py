"""Every shipped protocol runs on the simulated lab, as a user would run it."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from importlib.resources import files
from pathlib import Path

import pytest

from labrun.drivers.simulated.twins.minerals import atom_fractions
from labrun.engine.check import check_file
from labrun.engine.rehearse.rehearse import Rehearsal
from labrun.engine.views.explain import explain_protocol

SHIPPED = sorted(
    Path(str(entry))
    for entry in files("labrun.protocols").iterdir()
    if entry.name.endswith((".yaml", ".json"))
)
PEGMATITE = next(path for path in SHIPPED if path.stem == "pegmatite_map")
EXAMPLE = Path(__file__).parents[1] / "engine" / "examples" / "libs_grid_scan.yaml"
COMMAND = [sys.executable, "-m", "labrun.engine"]
SMALL = {
    "pegmatite_map": {"pitch": "1 mm"},
    "adaptive_map": {"shots": "4"},
    "colour_mix": {"wells": "2"},
    "furnace_night": {"hold": "10 min"},
    "refine_map": {"rounds": "2"},
    "find_and_scan": {"pitch": "20 mm"},
}
RUN_ELSEWHERE = {
    "adaptive_map", "autofocus_raster", "calibrate_camera", "calibrated_map", "colour_mix",
    "find_and_scan", "furnace_night", "multi_sample", "plate_96", "refine_map", "titration",
    "two_station", "wavelength_check", "weigh_and_dispense",
}  # fmt: skip
"""That these run, and deliver what they promise, is tested in test_promises.py."""


def labrun(folder, *words):
    return subprocess.run(
        [*COMMAND, *words, "--runs", "runs"],
        cwd=folder, capture_output=True, text=True,
    )  # fmt: skip


def only_run(folder):
    (found,) = (folder / "runs").iterdir()
    return found


def read_rows(run):
    with (run / "data.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def shots(run):
    lines = (run / "servers" / "world" / "truth" / "libs.jsonl").read_text().splitlines()
    return [entry for line in lines if (entry := json.loads(line))["what"] == "shot"]


def marked(paths, mark, *names):
    """Parameters of a test, of which the named ones bear a mark."""
    marks = dict.fromkeys(names, mark)
    return [pytest.param(p, id=p.stem, marks=marks.get(p.stem, ())) for p in paths]


def wait_for_rows(folder, count):
    until = time.monotonic() + 500
    while time.monotonic() < until:
        found = list((folder / "runs").glob("*/data.csv")) if (folder / "runs").exists() else []
        if found and len(found[0].read_text().splitlines()) > count:
            return
        time.sleep(0.01)


def kill_server(run, name):
    server = json.loads((run / "servers" / name / "server.json").read_text())
    os.kill(server["pid"], signal.SIGKILL)


def correlation(a, b):
    import numpy as np

    return np.corrcoef(a, b)[0, 1]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_protocol_checks_clean_is_short_and_can_be_explained(path):
    checked = check_file(path)

    assert [(p.line, p.code, p.message) for p in checked.problems] == []
    assert next(iter(explain_protocol(checked))).startswith(checked.protocol.name)
    assert len(path.read_text(encoding="utf-8").splitlines()) < 100


@pytest.mark.parametrize(
    "path", marked(SHIPPED, pytest.mark.soak, "calibrate_camera", "find_and_scan", "furnace_night")
)
def test_a_shipped_protocol_can_be_rehearsed(path):
    checked = check_file(path, params=SMALL.get(path.stem, {}))
    totals = Rehearsal(checked, {}).play()

    assert totals.fate == "succeeded", totals.as_dict()


@pytest.mark.parametrize(
    "path",
    marked(
        [p for p in SHIPPED if p.stem not in RUN_ELSEWHERE and p != PEGMATITE],
        pytest.mark.soak,
        "scan_core",
    ),
)
def test_a_shipped_protocol_runs_and_succeeds(path, tmp_path):
    small = [word for pair in SMALL.get(path.stem, {}).items() for word in ("-p", "=".join(pair))]
    ran = labrun(tmp_path, "run", str(path), *small)

    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "run succeeded" in ran.stdout


def test_one_protocol_ships_as_json():
    assert [path.name for path in SHIPPED if path.suffix == ".json"] == ["weigh_and_dispense.json"]


@pytest.mark.soak
def test_the_example_of_the_design_runs_when_its_question_is_answered(tmp_path):
    ran = labrun(tmp_path, "run", str(EXAMPLE), "--yes", "-p", "pitch=2 mm")

    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert len(read_rows(only_run(tmp_path))) == 18


@pytest.mark.soak
def test_the_maps_show_the_grains_that_the_simulated_core_was_given(tmp_path):
    ran = labrun(tmp_path, "run", str(PEGMATITE), "-p", "pitch=0.5 mm")

    run = only_run(tmp_path)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "run succeeded" in ran.stdout
    rows = {row["shot"]: row for row in read_rows(run)}
    fired = shots(run)
    assert len(fired) == len(rows) == 9 * 21
    for element in ("Li", "K"):
        seen = [float(rows[shot["shot"]][element]) for shot in fired]
        given = [atom_fractions(shot["mineral"]).get(element, 0.0) for shot in fired]
        assert correlation(seen, given) > 0.8, element
    assert (run / "element_maps.png").stat().st_size > 10_000
    assert (run / "report.html").stat().st_size > 10_000
    spectra = sorted((run / "spectra").glob("*.csv"))
    assert len(spectra) == 9 * 21
    lines = spectra[0].read_text().splitlines()
    assert (lines[0], len(lines)) == ("wavelength,intensity", 22_801)


@pytest.mark.soak
def test_a_scan_whose_engine_is_killed_goes_on_in_focus_and_fires_no_shot_twice(tmp_path):
    command = [*COMMAND, "run", str(PEGMATITE), "-p", "pitch=2 mm", "--runs", "runs"]
    engine = subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    wait_for_rows(tmp_path, 5)
    engine.send_signal(signal.SIGKILL)
    engine.wait()

    went_on = labrun(tmp_path, "resume", "last")

    run = only_run(tmp_path)
    assert went_on.returncode == 0, went_on.stdout + went_on.stderr
    fired = shots(run)
    places = {(shot["x"], shot["y"]) for shot in fired}
    assert len(fired) == len(places) == 3 * 6
    assert min(shot["focus"] for shot in fired) > 0.99
    assert len(read_rows(run)) == 18


@pytest.mark.soak
def test_a_scan_outlives_the_death_of_every_one_of_its_servers(tmp_path):
    command = [*COMMAND, "run", str(PEGMATITE), "-p", "pitch=1 mm", "--runs", "runs"]
    with (tmp_path / "said.txt").open("w") as said:
        engine = subprocess.Popen(command, cwd=tmp_path, stdout=said, stderr=subprocess.STDOUT)
    wait_for_rows(tmp_path, 5)
    for name in ("gantry", "libs", "reduce"):
        kill_server(only_run(tmp_path), name)
        time.sleep(0.5)

    status = engine.wait()

    run = only_run(tmp_path)
    said = (tmp_path / "said.txt").read_text()
    assert status == 0, said
    assert said.count("starts again") == 3
    goals = [shot["goal"] for shot in shots(run)]
    assert len(set(goals)) == len(goals)
    assert len(read_rows(run)) == 55
