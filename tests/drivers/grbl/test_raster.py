"""The paper's raster on a GRBL controller, by `labrun run`: every shot from a standstill, in place."""

import json
import os
import re
import subprocess
import sys
from datetime import datetime
from pathlib import Path

import pytest

ORIGIN = (-805.0, -725.0, -90.0)

LAB = """
name: raster
devices:
  gantry:
    contract: gantry@1
    driver: grbl
    config: {{port: {port}}}
  libs:
    contract: libs_analyzer@1
    driver: sim_libs
    config: {{clock: fast, gantry: gantry}}
"""
PROTOCOL = """
labrun: 1
name: raster
devices: {gantry: gantry@1, libs: libs_analyzer@1}
params:
  width: {type: quantity, unit: mm, default: 4 mm}
  height: {type: quantity, unit: mm, default: 10 mm}
  pitch: {type: quantity, unit: mm, default: 0.2 mm}
defaults: {timeout: 30 s}
steps:
  - {do: gantry.home}
  - id: scan
    foreach:
      point: >-
        ${{ grid(x=span(0, params.width, params.pitch), y=span(0, params.height, params.pitch),
        order='columns') }}
    key: ${{ point.ix }},${{ point.iy }}
    steps:
      - {do: gantry.move_to, with: {z: 5}}
      - {do: gantry.move_to, with: {x: "${{ point.x + 1 mm }}", y: "${{ point.y + 1 mm }}"}}
      - {do: gantry.move_to, with: {z: 0}}
      - {do: libs.measure}
finally:
  - {do: libs.disarm, on_error: continue}
"""
PITCH = 0.2


def scan(peer, folder: Path, **params: str) -> list[dict]:
    """Run the protocol; the shots that the analyser really fired."""
    lab = folder / "lab.yaml"
    protocol = folder / "raster.yaml"
    protocol.write_text(PROTOCOL)
    lab.write_text(LAB.format(port=peer.path))
    given = [part for name, value in params.items() for part in ("-p", f"{name}={value}")]
    command = [
        sys.executable, "-m", "labrun.engine", "run", str(protocol), "--yes",
        "--lab", str(lab), "--runs", str(folder / "runs"), "--json", *given,
    ]  # fmt: skip
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    truth = next((folder / "runs").glob("*/servers/world/truth/libs.jsonl"))
    return [json.loads(line) for line in truth.read_text().splitlines()]


def aimed_at(shot: dict) -> tuple[float, float, float]:
    """Where the protocol wanted this shot: the key of its point is in the goal's id."""
    found = re.search(r"/(\d+),(\d+)/", shot["goal"])
    assert found is not None
    return 1 + int(found[1]) * PITCH, 1 + int(found[2]) * PITCH, 0.0


def check(peer, shots: list[dict]) -> float:
    """No shot in motion, none out of place; the largest distance from where it was aimed."""
    worst = 0.0
    for shot in shots:
        wall = datetime.fromisoformat(shot["at"]).timestamp()
        assert not peer.moving_at(wall), shot
        true = [at - zero for at, zero in zip(peer.stood_at(wall), ORIGIN, strict=True)]
        apart = [abs(a - b) for a, b in zip(true, aimed_at(shot), strict=True)]
        worst = max(worst, *apart)
    return worst


@pytest.mark.slow
def test_sixty_points_are_shot_at_a_standstill_within_five_micrometres(peers, tmp_path):
    peer = peers(speed=100)

    shots = scan(peer, tmp_path, width="1.8 mm", height="1 mm")

    assert len({shot["goal"] for shot in shots}) == len(shots) == 60
    assert check(peer, shots) <= 0.005
    assert peer.overrun == 0


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_the_whole_raster_of_1071_points(peers, tmp_path):
    peer = peers(speed=100)

    shots = scan(peer, tmp_path)

    assert len({shot["goal"] for shot in shots}) == len(shots) == 1071
    assert check(peer, shots) <= 0.005
    assert peer.overrun == 0
