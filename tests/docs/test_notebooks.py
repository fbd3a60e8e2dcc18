"""The notebooks of the docs run from top to bottom in a kernel, and show what they say."""

import json
import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
SHOWN = {
    "by-hand": [
        "<Quantity(60",
        "6 s is a time",
        "- do: balance.zero",
        "run succeeded",
        "'mass_",
    ],
    "first-scan": [
        "no problems",
        "1 s is a time",
        "'gantry.move_to': 15",
        "15 of 15 measured",
        "image/png",
    ],
    "spectra": ["4 of 4 measured", "image/png", "(4, 22800) ['x', 'wavelength'] nm"],
}
"""Notebook -> what its outputs have in them."""


def test_every_notebook_is_known_and_kept_without_outputs():
    read = [json.loads(path.read_bytes())["cells"] for path in NOTEBOOKS]
    cells = [cell for book in read for cell in book if cell["cell_type"] == "code"]

    assert [path.stem for path in NOTEBOOKS] == sorted(SHOWN)
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in cells)


@pytest.mark.slow
@pytest.mark.needs("kernel")
@pytest.mark.filterwarnings("ignore")  # those of Jupyter's own libraries
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_what_it_says(path, tmp_path, monkeypatch):
    import nbclient
    import nbformat

    beside = Path(sys.executable).parent
    monkeypatch.setenv("PATH", f"{beside}{os.pathsep}{os.environ['PATH']}")  # `!labrun`
    book = nbformat.read(path, 4)
    resources = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(book, timeout=300, resources=resources).execute()
    outputs = [one for cell in book.cells if cell.cell_type == "code" for one in cell.outputs]
    # What is printed may come in several pieces.
    shown = str(outputs) + "".join(one.get("text", "") for one in outputs)

    assert [words for words in SHOWN[path.stem] if words not in shown] == []
