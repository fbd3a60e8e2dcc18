"""A whole run of the engine over the paper's server: a point, its shot, its spectrum in the run's folder."""

import csv
import json
import subprocess
import sys

import pytest

PROTOCOL = """labrun: 1
name: one-point
devices: {libs: libs_analyzer@1, gantry: gantry@1}
steps:
  - parallel:
      - {do: gantry.home, timeout: 2 min}
      - {do: libs.locate, timeout: 1 min}
  - id: scan
    foreach: {point: "${{ grid(x=span(3, 3, 1), y=span(4, 4, 1)) }}"}
    steps:
      - {do: gantry.move_to, with: {x: "${{ point.x }}", y: "${{ point.y }}"}}
      - {id: shoot, do: libs.measure, timeout: 1 min}
      - id: export
        do: libs.export
        with: {shot: "${{ steps.shoot.shot_id }}", file: "spectra/core.csv"}
        timeout: 1 min
    collect: {x: "${{ point.x }}", shot: "${{ steps.shoot.shot_id }}"}
finally:
  - {do: libs.disarm}
"""


def run(folder, bench, **config):
    """`labrun run` of one point, with a simulated gantry and the server of the bench."""
    url = f"http://127.0.0.1:{bench.port}"
    known = {"url": url, "exports": str(folder / "exports"), "cache": bench.cache}
    lab = {
        "devices": {
            "libs": {"contract": "libs_analyzer@1", "driver": "aecp", "config": known | config},
            "gantry": {
                "contract": "gantry@1", "driver": "sim_gantry", "config": {"clock": "fast"},
            },
        }
    }  # fmt: skip
    (folder / "lab.json").write_text(json.dumps(lab))
    (folder / "one.yaml").write_text(PROTOCOL)
    return subprocess.run(
        [sys.executable, "-m", "labrun.engine", "run", "one.yaml", "--lab", "lab.json", "--yes"],
        cwd=folder, capture_output=True, text=True,
    )  # fmt: skip


@pytest.mark.slow
def test_one_point_from_homing_to_the_spectrum(aecp, tmp_path):
    aecp.start()
    done = run(tmp_path, aecp)

    assert done.returncode == 0, done.stdout + done.stderr
    (folder,) = (tmp_path / "runs").glob("*_one-point_*")
    with (folder / "data.csv").open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert row["shot"] == "shot-000001"
    assert len((folder / "spectra" / "core.csv").read_text().splitlines()) == 2001
    assert aecp.shots() == 1


@pytest.mark.slow
def test_a_shot_whose_answer_was_lost_goes_on_without_a_second_one(aecp, tmp_path):
    aecp.start(plans={"measure": ["mute"]})
    done = run(tmp_path, aecp, measure_s=3)

    assert done.returncode == 0, done.stdout + done.stderr
    assert aecp.shots() == 1


@pytest.mark.slow
def test_a_server_that_is_not_there_is_told_before_anything_begins(aecp, tmp_path):
    aecp.start()
    aecp.end()
    done = run(tmp_path, aecp, exports=str(tmp_path), cache=None, connect_s=2)

    assert done.returncode == 4, done.stdout + done.stderr
    assert "device libs cannot be opened: the analyser server at" in done.stderr
    assert f"http://127.0.0.1:{aecp.port} cannot be reached" in done.stderr
    assert "Traceback" not in done.stderr
