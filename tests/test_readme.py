"""The README tells the truth: its protocol checks clean and runs, its pictures and links exist."""

import re
import subprocess
import sys
from pathlib import Path

import cv2

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


FIRST = re.search(r"```yaml\n(.*?)```", README, re.S)[1]


def labrun(folder, *words):
    return subprocess.run(
        [sys.executable, "-m", "labrun", *words],
        cwd=folder, capture_output=True, text=True,
    )  # fmt: skip


def test_the_first_protocol_is_the_one_that_ships_and_checks_without_a_warning(tmp_path):
    path = ROOT / "protocols" / "fill_plate.yaml"
    checked = labrun(tmp_path, "check", str(path))

    assert path.read_text(encoding="utf-8") == FIRST
    assert "no problems" in checked.stdout


def test_the_first_picture_is_what_preview_draws(tmp_path):
    (tmp_path / "fill.yaml").write_text(FIRST, encoding="utf-8")
    drawn = labrun(tmp_path, "preview", "fill.yaml", "-o", "drawn.png")
    shown = [
        cv2.imread(str(path)).astype(float)
        for path in (ROOT / "docs" / "fill_plate.png", tmp_path / "drawn.png")
    ]

    assert drawn.returncode == 0, drawn.stderr
    assert shown[0].shape == shown[1].shape
    assert abs(shown[0] - shown[1]).mean() < 1.0


def test_every_file_that_the_readme_points_to_is_there():
    links = re.findall(r"\]\((?!http)([^)#]+)\)", README)

    assert [link for link in links if not (ROOT / link).exists()] == []
