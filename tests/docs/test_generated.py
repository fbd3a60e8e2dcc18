"""The pages of the reference that are made from code are what the code says."""

import importlib.util
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "docs" / "reference"
NAMES = ("cli.md", "contracts.md", "language.md", "python.md")


def load():
    spec = importlib.util.spec_from_file_location("generate", FOLDER / "generate.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


generate = load()


@pytest.mark.parametrize("name", NAMES)
def test_the_page_is_what_the_code_says(name):
    written = (FOLDER / name).read_text(encoding="utf-8")

    assert written == generate.PAGES[name](), "python docs/reference/generate.py rewrites it"


def test_every_key_function_and_option_has_words():
    empty = [
        line
        for name in ("cli.md", "language.md")
        for line in (FOLDER / name).read_text("utf-8").splitlines()
        if line.startswith("| `") and line.endswith("` |  |")
    ]

    assert empty == []
