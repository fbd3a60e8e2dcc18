"""The map of the house names rooms and files that are there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "architecture.md").read_text("utf-8")
PATHS = sorted(
    set(re.findall(r"`((?:web|engine|drivers|reduction|schemas|system)/[\w/.]*)`", PAGE))
)


@pytest.mark.parametrize("path", PATHS)
def test_every_path_that_the_page_names_is_there(path):
    assert (ROOT / path).exists()


def test_every_room_in_the_drawing_is_a_room_of_its_folder():
    drawing = re.search(r"```mermaid\n(.*?)```", PAGE, re.S)[1]
    for folder, body in re.findall(r"subgraph (\w+)\n(.*?)\n  end", drawing, re.S):
        labels = re.findall(r'\["([^"]+)"\]', body)
        names = re.findall(
            r"\b([a-z_]+)\b(?!\[)", re.sub(r'\["[^"]+"\]|direction LR|Socket\.IO', "", body)
        )
        rooms = {name for label in labels for name in re.split(r" · ", label)}
        aliases = set(re.findall(r"([a-z_]+)\[", body))
        for name in rooms | (set(names) - aliases):
            assert any((ROOT / folder / end).exists() for end in (name, f"{name}.py")), name
