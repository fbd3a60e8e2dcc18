"""The first steps can be taken: protocols check, pictures are there, and all of it runs."""

import importlib.util
from pathlib import Path

import pytest

from labrun.engine.check import check_file

FOLDER = Path(__file__).parents[2] / "docs" / "first-steps"
PAGES = sorted(FOLDER.glob("*.md"))


def load():
    spec = importlib.util.spec_from_file_location("first_steps", FOLDER / "run.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


steps = load()


def test_the_sweep_checks_clean_and_its_mistake_is_found(tmp_path):
    for name, text in steps.files((FOLDER / "physicist.md").read_text("utf-8")).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    lab, sweep = tmp_path / "lab.yaml", tmp_path / "sweep.yaml"
    wrong = check_file(sweep, lab=lab, params={"top": "3 V"})

    assert list(check_file(sweep, lab=lab).problems) == []
    assert [problem.severity for problem in wrong.problems] == ["error"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_picture_is_there_and_small(page):
    names = steps.PICTURE.findall(page.read_text("utf-8"))

    assert [name for name in names if (FOLDER / name).stat().st_size > 120_000] == []


@pytest.mark.soak
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_says_runs_as_it_stands(page):
    steps.run(page)
