"""The page on adding a device and the one on labs: every block of code stands in the project itself."""

import re
from pathlib import Path

import pytest

from labrun.engine.lab.lab import load_lab

ROOT = Path(__file__).parents[2]
PAGES = ["add-a-device", "labs"]
BLOCK = re.compile(r"```(?:yaml|python|toml)\n# ([\w/.]+)\n(.*?)```", re.S)


def page(name: str) -> str:
    return (ROOT / "docs" / "how-to" / f"{name}.md").read_text(encoding="utf-8")


QUOTED = [(name, *found) for name in PAGES for found in BLOCK.findall(page(name))]


@pytest.mark.parametrize(("name", "file", "code"), QUOTED)
def test_every_block_stands_in_the_file_that_it_names(name, file, code):
    assert code in (ROOT / file).read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "others"), [("add-a-device", 0), ("labs", 1)])
def test_no_block_of_code_comes_from_nowhere(name, others):
    blocks = re.findall(r"```(?:yaml|python|toml)\n", page(name))

    assert len(blocks) - sum(quoted[0] == name for quoted in QUOTED) == others
    assert len(blocks) > others


def test_the_lab_with_every_key_is_a_lab(tmp_path):
    for folder in ("lab", "shared"):
        (tmp_path / folder).mkdir()
    (tmp_path / "lab" / "furnace.yaml").write_text("type: oven@1\nactions: {heat: {}}\n")
    (block,) = re.findall(r"```yaml\n(name: cellar.*?)```", page("labs"), re.S)
    path = tmp_path / "lab" / "lab.yaml"
    path.write_text(block)
    lab, problems = load_lab(path)

    assert problems == []
    assert lab is not None and set(lab.lab.devices) == {"oven", "scale", "gantry"}


def test_every_key_of_a_lab_is_on_its_page():
    from labrun.schemas.lab import Lab, LabDevice

    keys = {*Lab.model_fields, *LabDevice.model_fields}

    assert [key for key in sorted(keys) if f"`{key}`" not in page("labs")] == []
