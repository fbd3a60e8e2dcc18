"""The pages of the reference that are made from code are what the code says."""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "reference"
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


def test_every_option_that_the_manual_types_is_one_of_its_command():
    page = (FOLDER / "cli.md").read_text("utf-8")
    options = {
        part.partition("\n")[0]: set(re.findall(r"(?<![\w-])--[a-z][\w-]*", part))
        for part in page.split("\n### labrun ")[1:]
    }
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "docs").rglob("*.ipynb")]
    typed = re.compile(r"labrun ([a-z][a-z-]+(?: standards| response)?)((?: [^`\n|#&;]*)?)")
    unknown, seen = [], 0
    for path in pages:
        if path.name in ("cli.md", "CHANGELOG.md"):
            continue
        for command, rest in typed.findall(path.read_text("utf-8")):
            name = command if command in options else command.split()[0]
            for option in re.findall(r"(?<![\w-])--[a-z][\w-]*", rest):
                seen += 1
                if option not in options.get(name, ()):
                    unknown.append(f"{path.name}: labrun {name} {option}")

    assert seen > 100
    assert unknown == []
