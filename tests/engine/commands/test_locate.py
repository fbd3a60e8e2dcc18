"""`labrun locate` as a person runs it, on a photograph with known truth."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from scenes import Chessboard, Lens, photograph, stand

from ...command_line import labrun

LENS = Lens(640, 360, 532.5, (326.0, 174.0), (-0.08, 0.03, 0.001, -0.0007, 0.0))
TRUTH = Chessboard(x=0, y=0)
PLACE = stand(TRUTH.middle() - (0, 30, 0), 500, 30, 5, 3)


def save(path: Path, grey) -> None:
    path.parent.mkdir(exist_ok=True)
    assert cv2.imwrite(str(path), grey)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A photograph, its depth map and a camera file."""
    folder, random = tmp_path_factory.mktemp("scene"), np.random.default_rng(1)
    grey, depth = photograph(LENS, PLACE, TRUTH, random)
    save(folder / "scene.png", grey)
    save(folder / "depth.png", np.round(depth * 10).astype(np.uint16))
    camera = {
        "width": 640, "height": 360, "matrix": LENS.matrix().tolist(),
        "distortion": list(LENS.distortion), "board": {"columns": 9, "rows": 6, "square": 25.0},
    }  # fmt: skip
    (folder / "cam.yaml").write_text(yaml.safe_dump(camera))
    return folder


def locate(lab, *words):
    return labrun(lab, "locate", "--image", "scene.png", "--camera", "cam.yaml", *words)


@pytest.mark.slow
def test_a_pixel_is_placed_by_its_depth_and_by_its_height(lab):
    u, v = LENS.pixels(PLACE.seen(np.array([40.0, -30.0, 0.0])))
    by_depth = locate(lab, "--depth", "depth.png", "--pixel", f"{u:.2f},{v:.2f}", "--json")
    by_height = locate(lab, "--pixel", f"{u:.2f},{v:.2f}", "--height", "0 mm")
    point = json.loads(by_depth.stdout)
    first = by_height.stdout.splitlines()[0].replace(",", "").split()
    x, y, z = (float(first[n]) for n in (1, 4, 7))

    assert (point["x"], point["y"], point["z"]) == pytest.approx((40, -30, 0), abs=0.8)
    assert 0 < point["uncertainty"] < 6 and point["rms"] < 0.3
    assert [point["camera"][axis] for axis in "xyz"] == pytest.approx(PLACE.place, abs=1.5)
    assert (x, y, z) == pytest.approx((40, -30, 0), abs=0.4)
    assert "19 times out of 20" in by_height.stdout


@pytest.mark.soak
def test_the_board_may_lie_elsewhere_and_be_told_on_the_command_line(lab):
    u, v = LENS.pixels(PLACE.seen(np.array([40.0, -30.0, 0.0])))
    pixel = f"{u:.2f},{v:.2f}"
    moved = locate(lab, "--pixel", pixel, "--height", "0", "--board-at", "100 mm,30 cm", "--json")
    doubled = locate(lab, "--pixel", pixel, "--height", "0", "--square", "50 mm", "--json")

    assert json.loads(moved.stdout)["x"] == pytest.approx(140, abs=0.4)
    assert json.loads(moved.stdout)["y"] == pytest.approx(270, abs=0.4)
    assert json.loads(doubled.stdout)["x"] == pytest.approx(80, abs=0.8)


@pytest.mark.soak
def test_what_cannot_be_located_is_a_sentence(lab):
    camera = yaml.safe_load((lab / "cam.yaml").read_text())
    (lab / "boardless.yaml").write_text(yaml.safe_dump({**camera, "board": None}))
    (lab / "large.yaml").write_text(yaml.safe_dump({**camera, "width": 1280, "height": 720}))
    grey = cv2.imread(str(lab / "scene.png"), cv2.IMREAD_GRAYSCALE)
    save(lab / "mirrored.png", np.fliplr(grey))
    save(lab / "rotated.png", cv2.resize(np.rot90(grey), (640, 360)))
    save(lab / "small.png", np.ones((20, 30), np.uint16))
    np.save(lab / "nan.npy", np.full((360, 640), np.nan, np.float32))
    pixel, depth = ("--pixel", "300,200"), ("--depth", "depth.png")
    cases = [
        ([*pixel], "this camera sees no depth: give the height"),
        (["--pixel", "640,0", *depth], "pixel 640, 0 is not in a picture of 640 x 360"),
        (["--pixel", "3", *depth], "write two numbers separated by a comma"),
        (["--pixel", "nan,3", *depth], "write two numbers separated by a comma"),
        (
            [*pixel, "--depth", "small.png"],
            "the depth map is 30 x 20, and the picture is 640 x 360",
        ),
        ([*pixel, "--depth", "nan.npy"], "the depth map contains no depth"),
        ([*pixel, "--depth", "scene.png"], "not a depth map"),
        ([*pixel, *depth, "--depth-unit", "1 mm"], "and the depth unit right?"),
        ([*pixel, *depth, "--image", "mirrored.png"], "mirrored"),
        ([*pixel, *depth, "--image", "rotated.png"], "turned by 90 degrees"),
        ([*pixel, *depth, "--image", "cam.yaml"], "cam.yaml is not a picture"),
        ([*pixel, *depth, "--camera", "scene.png"], "scene.png is not text"),
        ([*pixel, *depth, "--camera", "boardless.yaml"], "add --board 9x6 --square"),
        (
            [*pixel, *depth, "--camera", "large.yaml"],
            "pictures of 1280 x 720, and this one is 640 x 360",
        ),
        ([*pixel, *depth, "--board", "6x9"], "it is a board of 9 x 6"),
        ([*pixel, *depth, "--x-runs", "north"], "choose one of right, up, left, down"),
        ([*pixel, "--height", "3 kg"], "--height 3 kg"),
    ]
    for words, sentence in cases:
        done = locate(lab, *words)

        assert (done.returncode, done.stdout) == (2, ""), (words, done.stderr)
        assert sentence in done.stderr, (words, done.stderr)
        assert "Traceback" not in done.stderr
