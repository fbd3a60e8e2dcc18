"""A whole run of the engine with the real program on the bench: every point a shot and a spectrum."""

import csv
import json
import subprocess
import sys

import pytest

PROTOCOL = """labrun: 1
name: two-points
devices: {libs: libs_analyzer@1, gantry: gantry@1}
steps:
  - {do: libs.locate, timeout: 1 min}
  - id: scan
    foreach: {x: "${{ range(2) }}"}
    steps:
      - {do: gantry.move_to, with: {x: "${{ x }}"}}
      - {id: shoot, do: libs.measure, timeout: 2 min}
      - id: export
        do: libs.export
        with: {shot: "${{ steps.shoot.shot_id }}", file: "s/${{ x }}.csv"}
        timeout: 2 min
    collect: {shot: "${{ steps.shoot.shot_id }}"}
finally:
  - {do: libs.disarm}
"""


@pytest.mark.soak
def test_a_run_with_a_simulated_gantry_and_a_real_program(gui, tmp_path):
    analyser = gui.start()
    lab = {
        "devices": {
            "libs": {
                "contract": "libs_analyzer@1", "driver": "sciaps_gui",
                "config": gui.config(delete="file"),
            },
            "gantry": {
                "contract": "gantry@1", "driver": "sim_gantry",
                "config": {"clock": "fast", "homed": True},
            },
        }
    }  # fmt: skip
    (tmp_path / "lab.json").write_text(json.dumps(lab))
    (tmp_path / "two.yaml").write_text(PROTOCOL)
    said = tmp_path / "said.txt"
    with said.open("w") as log:
        engine = subprocess.Popen(
            [sys.executable, "-m", "labrun.engine", "run", "two.yaml", "--lab", "lab.json", "--yes"],
            cwd=tmp_path, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
        )  # fmt: skip
        try:
            status = engine.wait(500)
        except subprocess.TimeoutExpired:  # it asks something, perhaps
            engine.kill()
            status = engine.wait()

    stands = f"{analyser.shots()} shots, the program is {analyser.order('state')}"
    assert status == 0, f"{said.read_text()}\n{stands}"
    (run,) = (tmp_path / "runs").glob("*_two-points_*")
    with (run / "data.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["shot"] for row in rows] == ["shot-000001", "shot-000002"]
    assert all(len((run / "s" / f"{n}.csv").read_text().splitlines()) == 2001 for n in (0, 1))
    assert (analyser.shots(), analyser.entries()) == (2, set())
