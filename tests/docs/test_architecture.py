"""The map of the house names rooms and files that are there."""

import itertools
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


def arrows():
    """(folder, importing rooms, imported rooms) of each solid arrow within a folder."""
    drawing = re.search(r"```mermaid\n(.*?)```", PAGE, re.S)[1]
    for folder, body in re.findall(r"subgraph (\w+)\n(.*?)\n  end", drawing, re.S):
        labels = {name: text.split(" · ") for name, text in re.findall(r'(\w+)\["(.*?)"\]', body)}
        for line in re.sub(r'\["[^"]+"\]', "", body).splitlines():
            if "-->" in line:
                chain = [part.split()[-1] for part in line.split("-->")]
                for above, below in itertools.pairwise(chain):
                    yield folder, labels.get(above, [above]), labels.get(below, [below])


def imports(folder, above, below):
    place = ROOT / folder / above
    files = place.rglob("*.py") if place.is_dir() else [place.with_suffix(".py")]
    wanted = re.compile(rf"from \.+{below.removesuffix('.py')}\b", re.M)
    return any(wanted.search(file.read_text("utf-8")) for file in files)


def test_every_arrow_in_the_drawing_is_an_import():
    drawn = list(arrows())

    assert len(drawn) > 20
    for folder, above, below in drawn:
        assert any(imports(folder, a, b) for a in above for b in below), (folder, above, below)
