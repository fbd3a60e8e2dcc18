"""The house: which rooms there are, what each says of itself, and names that a stranger guesses."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = ("drivers", "engine", "reduction", "schemas", "system", "web")
DOORS = {
    "engine": {"__init__", "__main__", "check", "cli", "exit_status"},
    "drivers": {"__init__", "driver", "find", "reducer", "world"},
    "reduction": {"__init__", "reduce", "warm_up"},
    "system": {
        "__init__",
        "cells",
        "extras",
        "files",
        "keyboard",
        "output",
        "pace",
        "page",
        "process",
        "signals",
        "start",
        "tasks",
        "websocket",
    },
    "web": {"__init__"},
}
ROOMS = sorted(
    path.parent
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("__init__.py")
    if "node_modules" not in path.parts
)
OLD_NAMES = {
    "": """
        Life Wishes wishes Reached lookout Lookout following Following holding Holding news News
        presence Presence strangers bygone closing Closing Turns instant Instant ordeal Ordeal doom
        doomed toll Toll witness Witness shelf Shelf station Station Opening opening Site site gone
        Sight sight Handling handling Story story Tally tally Material material Markup markup by_hand
        ByHand on_bench OnBench telling Telling Said ShotBook kept Kept arrival Crew crew commonness
        told Told settle watched Watched touched
    """,
    "drivers/grbl": "words said stand",
    "engine/torture": "Stand stand",
    "engine": "turns",
    "reduction": "weigh",
    "web": "bench Bench live push Push guard",
}
"""Folder -> names that only their author could guess; STYLE.md has the glossary of today's."""


def python_files():
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            if "node_modules" not in path.parts:
                yield path


@pytest.mark.parametrize("folder", DOORS)
def test_the_root_of_a_folder_shows_its_doors_and_rooms(folder):
    assert {path.stem for path in (ROOT / folder).glob("*.py")} == DOORS[folder]


@pytest.mark.parametrize("room", ROOMS, ids=lambda room: str(room.relative_to(ROOT)))
def test_a_room_says_what_it_is_and_what_it_never_does(room):
    text = ast.get_docstring(ast.parse((room / "__init__.py").read_text("utf-8"))) or ""

    assert text.partition("\n")[0].endswith((".", "?"))
    assert re.search(r"\b(never|not|nothing|no|only)\b", text.partition("\n")[2].lower())


def test_no_file_class_function_or_room_bears_an_old_name():
    found = []
    for path in python_files():
        place = path.relative_to(ROOT)
        names = set(
            re.findall(r"^\s*(?:class|(?:async )?def) (\w+)", path.read_text("utf-8"), re.M)
        )
        names |= {path.stem, *place.parts[1:-1]}
        for folder, old in OLD_NAMES.items():
            if str(place).startswith(folder):
                found += [f"{place}: {name}" for name in sorted(names & set(old.split()))]

    assert found == []


def test_what_takes_every_exception_says_why_on_its_line():
    """Except where it passes it on as it is."""
    found = []
    for path in python_files():
        text = path.read_text("utf-8")
        if re.search(r"\b(Base)?Exception\b|except\s*:|suppress\(\)", text) is None:
            continue
        lines = text.splitlines()
        for node in ast.walk(ast.parse(text)):
            match node:
                case ast.ExceptHandler(type=kind, body=[*_, last]):
                    passed_on = isinstance(last, ast.Raise) and last.exc is None
                    kinds = [] if passed_on else [kind]
                case ast.Call(func=ast.Name("suppress") | ast.Attribute(attr="suppress")):
                    kinds = node.args
                case _:
                    continue
            for kind in kinds:
                broad = kind is None or ast.unparse(kind) in ("Exception", "BaseException")
                if broad and "  # " not in lines[node.lineno - 1]:
                    found.append(f"{path.relative_to(ROOT)}:{node.lineno}")

    assert found == []


def test_nothing_but_spawn_creates_a_task():
    """Lint sees `asyncio.create_task`; a loop has the same method, and a group another."""
    creates = re.compile(r"\b(create_task|ensure_future|TaskGroup)\b")
    found = {
        str(p.relative_to(ROOT)) for p in python_files() if creates.search(p.read_text("utf-8"))
    }

    assert found == {str(Path("system/tasks.py"))}


@pytest.mark.parametrize("room", ROOMS, ids=lambda room: str(room.relative_to(ROOT)))
def test_pyserial_is_found_from_every_room(room):
    """A room called `serial` would be imported in its place by whoever stands in `drivers`."""
    program = "import serial; assert serial.Serial, serial.__file__"
    done = subprocess.run([sys.executable, "-c", program], cwd=room, capture_output=True, text=True)

    assert done.returncode == 0, done.stderr
