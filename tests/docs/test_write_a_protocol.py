"""The page for people who write protocols: everything on it checks clean."""

import re
import textwrap
from pathlib import Path

import pytest

from labrun.engine.check import check_file

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "how-to" / "write-a-protocol.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```yaml\n(.*?)```", PAGE, re.S)
FRAME = """labrun: 1
name: page
devices: {gantry: gantry@1, libs: libs_analyzer@1, reduce: spectrum_reducer@1, balance: balance@1}
steps:
"""


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.partition("\n")[0])
def test_every_piece_of_yaml_on_the_page_has_no_error(block, tmp_path):
    for shipped in (ROOT / "protocols").glob("*.*"):
        if shipped.suffix in (".yaml", ".csv"):
            (tmp_path / shipped.name).write_bytes(shipped.read_bytes())
    whole = block if block.startswith("labrun") else FRAME + textwrap.indent(block, "  ")
    path = tmp_path / "page.yaml"
    path.write_text(whole, encoding="utf-8")
    problems = check_file(path, needed=True).problems

    assert [str(p) for p in problems if p.severity == "error"] == []


def test_every_file_that_the_pages_point_to_is_there():
    for page in sorted((ROOT / "docs").rglob("*.md")):
        links = re.findall(r"\]\((?!http)([^)#\s]+)\)", page.read_text(encoding="utf-8"))

        assert [link for link in links if not (page.parent / link).exists()] == [], page
