"""The table of semantics and its tests are compared, both ways."""

import importlib.util
import re
import shutil
from pathlib import Path

import pytest

import labrun
from labrun.engine.check import check_file

FOLDER = Path(__file__).parent / "semantics"
A_TEST = re.compile(r'^(?:def test_(?=\w+\()|    \("(?=\w+",\s+"[^\s"]+ ))(\w+)', re.MULTILINE)
SHIPPED = Path(labrun.__file__).parent / "protocols"
HEADER = """labrun: 1
name: example
params: {dose: {type: quantity, unit: g, default: 1 g}}
devices:
  gantry: gantry@1
  libs: libs_analyzer@1
  reduce: spectrum_reducer@1
  balance: balance@1
  camera: depth_camera@1
"""


def load():
    spec = importlib.util.spec_from_file_location("semantics_page", FOLDER / "page.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


page = load()


def test_the_page_is_what_the_tests_say():
    written = page.PAGE.read_text(encoding="utf-8")

    assert written == page.page(), "python tests/engine/semantics/page.py rewrites it"


def test_every_row_is_a_test_and_every_test_a_row():
    rows = re.findall(r"\[(\w+)\]\(\S*/(test_\w+\.py)\) \|$", page.PAGE.read_text(), re.MULTILINE)
    tests = [
        (name, file.name)
        for file in FOLDER.glob("test_*.py")
        for name in A_TEST.findall(file.read_text())
    ]

    assert len(rows) > 200
    assert sorted(rows) == sorted(tests)


@pytest.mark.parametrize("family", page.families(), ids=lambda family: family.title)
def test_every_row_is_short_and_every_sentence_ends(family):
    for row in family.rows:
        assert len(row.case) <= 130, row.test
        assert len(row.fact) <= 200, row.test
        assert row.fact.endswith("."), row.test


@pytest.mark.parametrize("family", page.families(), ids=lambda family: family.title)
def test_every_example_checks_clean(family, tmp_path):
    shutil.copytree(SHIPPED, tmp_path, dirs_exist_ok=True)
    example = family.example
    if not re.search(r"^finally:", example, re.MULTILINE):
        example = "steps:\n" + "".join(f"  {line}\n" for line in example.splitlines())
        example += "finally: [{do: libs.disarm}]\n"
    else:
        example = "steps: [{do: gantry.home}]\n" + example
    file = tmp_path / "example.yaml"
    file.write_text(HEADER + example, encoding="utf-8")

    checked = check_file(file)

    fails = {"W412", "W420", "W421", "W422"}  # warnings of what would fail in the run
    wrong = [p for p in checked.problems if p.severity == "error" or p.code in fails]

    assert wrong == []
