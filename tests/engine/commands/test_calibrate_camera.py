"""`labrun calibrate-camera` as a person runs it, on photographs with known truth."""

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
BOARD = ("--board", "9x6", "--square", "25 mm")


def save(path: Path, grey) -> None:
    path.parent.mkdir(exist_ok=True)
    assert cv2.imwrite(str(path), grey)


def photographed(folder: Path, wanted: int) -> Path:
    """A folder with photographs for a calibration."""
    random, count = np.random.default_rng(1), 0
    while count < wanted:
        middle = TRUTH.middle() + np.append(random.uniform(-70, 70, 2), 0)
        angles = random.uniform(10, 45), random.uniform(0, 360), random.uniform(-20, 20)
        place = stand(middle, random.uniform(330, 500), *angles)
        seen = LENS.pixels(place.seen(TRUTH.corners()))
        if seen.min() > 12 and (seen < (628, 348)).all():
            save(folder / "cal" / f"{count}.png", photograph(LENS, place, TRUTH, random)[0])
            count += 1
    return folder


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    return photographed(tmp_path_factory.mktemp("lens"), 7)


@pytest.mark.soak
def test_a_lens_is_measured_told_and_written(lab):
    (lab / "cal" / "note.png").write_text("no picture")
    save(lab / "cal" / "wall.png", np.full((360, 640), 99, np.uint8))
    done = labrun(lab, "calibrate", "camera", "cal", *BOARD, "-o", "out/new.yaml")
    (lab / "cal" / "note.png").unlink()
    (lab / "cal" / "wall.png").unlink()
    kept = yaml.safe_load((lab / "out" / "new.yaml").read_text())

    assert done.returncode == 0, done.stderr
    assert "cal/0.png" in done.stdout and " pixel\n" in done.stdout
    assert "left out: cal/note.png is not a picture" in done.stdout
    assert "cal/wall.png  left out: no complete chessboard of 9 x 6" in done.stdout
    assert "over 7 pictures of 640 x 360" in done.stdout
    assert "more pictures give a surer result" in done.stdout
    assert done.stderr == "labrun: out/new.yaml written\n"
    assert kept["matrix"][0][0] == pytest.approx(LENS.focal, rel=0.02)
    assert kept["board"] == {"columns": 9, "rows": 6, "square": 25.0}


@pytest.mark.slow
def test_the_report_is_json_for_programs_and_the_camera_yaml_on_standard_output(tmp_path):
    lab = photographed(tmp_path, 5)
    done = labrun(lab, "calibrate-camera", "cal", *BOARD, "--json")
    plain = labrun(lab, "calibrate-camera", "cal", *BOARD)
    report = json.loads(done.stdout)

    assert [image["used"] for image in report["images"]] == [True] * 5
    assert report["rms"] < 0.15 and report["written"] is None
    # Threads add up in any order: the last digits differ from run to run.
    matrix = yaml.safe_load(plain.stdout)["matrix"]
    assert np.allclose(matrix, report["camera"]["matrix"], rtol=1e-6)
    assert "reprojection error" in plain.stderr


@pytest.mark.soak
def test_what_cannot_be_calibrated_is_a_sentence(lab):
    (lab / "empty").mkdir(exist_ok=True)
    save(lab / "mixed" / "a.png", np.zeros((20, 30), np.uint8))
    (lab / "text.png").write_text("no picture")
    cases = [
        (["empty", *BOARD], "empty holds no pictures"),
        (["none.png", *BOARD], "none.png cannot be read: No such file"),
        (["text.png", *BOARD], "text.png is not a picture"),
        (["cal/0.png", "cal/1.png", *BOARD], "only 2 of 2 pictures show the complete board"),
        (["cal/0.png", "mixed", *BOARD], "640 x 360: cal/0.png; 30 x 20: mixed/a.png"),
        (["cal/0.png", "--board", "8x5x2", "--square", "1 mm"], "write columns x rows"),
        (
            ["cal/0.png", "--board", "10x7", "--square", "1 mm"],
            "none of 1 pictures shows a complete board of 10 x 7",
        ),
        (["cal/0.png", "--board", "9x6", "--square", "1 s"], "--square 1 s:"),
        (["cal/0.png", "--board", "9x6", "--square", "0 mm"], "a length above 0"),
    ]
    for words, sentence in cases:
        done = labrun(lab, "calibrate-camera", *words)

        assert (done.returncode, done.stdout) == (2, ""), words
        assert sentence in done.stderr, done.stderr
        assert "Traceback" not in done.stderr
