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


def typed(text):
    """What a page types after `labrun`: in blocks of a shell, and in code within its sentences."""
    blocks = re.findall(r"^ *```(\w*)\n(.*?)^ *```", text, re.S | re.M)
    lines = [line for kind, body in blocks if kind in ("sh", "ini") for line in body.splitlines()]
    lines += re.findall(r"`([^`\n]+)`", re.sub(r"^ *```.*?^ *```", "", text, flags=re.S | re.M))
    command = re.compile(r"^\s*(?:\$ |ExecStart=|docker compose exec page )?(?:\S*/)?labrun (\S.*)")
    for line in lines:
        for part in re.split(r"[;&|]|\s#", line):
            if found := command.match(part):
                yield found[1].split(">")[0].split()


def test_every_command_that_the_manual_types_exists_with_its_options():
    page = (FOLDER / "cli.md").read_text("utf-8")
    option = re.compile(r"(?<![\w=-])--?[a-z][\w-]*")
    options = {
        part.partition("\n")[0]: {
            *option.findall(part),
            "--help",
            "--version",
            "--install-completion",
        }
        for part in page.split("\n### labrun ")[1:]
    }
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "docs").rglob("*.ipynb")]
    unknown, seen = [], 0
    for path in pages:
        if path.name in ("cli.md", "CHANGELOG.md") or "node_modules" in path.parts:
            continue
        for words in typed(path.read_text("utf-8")):
            first = words[0]
            is_file = re.search(r"\.ya?ml$|^[A-Z]+$|^-", first)
            name = next((n for n in (" ".join(words[:2]), first) if n in options), "")
            name = name or ("run" if is_file else first)
            wrong = [
                one for one in option.findall(" ".join(words)) if one not in options.get(name, ())
            ]
            seen += 1
            if (name not in options and name != "COMMAND") or wrong:
                unknown.append(f"{path.name}: labrun {' '.join(words)}")

    assert seen > 200
    assert unknown == []
