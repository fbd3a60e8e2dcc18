"""The page for notebooks: its code runs, from top to bottom."""

import inspect
import re
from pathlib import Path

import pytest

import labrun

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "how-to" / "notebook.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_every_piece_of_python_on_the_page_runs(tmp_path, monkeypatch, capsys):
    pytest.importorskip("xarray")
    monkeypatch.chdir(tmp_path)
    Path("scan.yaml").write_text(re.findall(r"```yaml\n(.*?)```", PAGE, re.S)[0], encoding="utf-8")
    bench = ROOT / "protocols" / "labs" / "simulated.yaml"
    Path("bench.yaml").write_text(bench.read_text(encoding="utf-8"), encoding="utf-8")
    names = {}
    for block in re.findall(r"```python\n(.*?)```", PAGE, re.S):
        exec(compile(block, "notebook.md", "exec"), names)

    assert names["run"].fate == "succeeded" and len(names["best"]) == 2
    assert names["image"].shape == (3, 5) and abs(names["image"]).max() < 0.1
    assert names["frame"].attrs["units"] == {"x_mm": "mm", "y_mm": "mm", "off_mm": "mm"}
    assert "run succeeded" in capsys.readouterr().out


def test_every_name_that_labrun_offers_is_on_the_page_and_documented():
    offered = {name: getattr(labrun, name) for name in labrun.__all__}
    returned = {"RecordedRun", "LiveRun", "Lab", "ActionFailed"}

    assert [n for n in offered if n not in returned and not re.search(rf"\b{n}\b", PAGE)] == []
    assert [name for name, value in offered.items() if not inspect.getdoc(value)] == []
