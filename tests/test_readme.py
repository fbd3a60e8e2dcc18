"""The README tells the truth: its protocol checks clean and runs, its pictures and links exist."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_first_protocol_of_the_readme_runs(tmp_path):
    yaml = re.search(r"```yaml\n(.*?)```", README, re.S)[1]
    (tmp_path / "little.yaml").write_text(yaml, encoding="utf-8")

    ran = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "little.yaml"],
        cwd=tmp_path, capture_output=True, text=True, timeout=110,
    )  # fmt: skip

    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "element_maps.png" in ran.stdout


def test_every_file_that_the_readme_points_to_is_there():
    links = re.findall(r"\]\((?!http)([^)#]+)\)", README)

    assert [link for link in links if not (ROOT / link).exists()] == []
