"""Every shipped protocol with anything in it missing, renamed, of another type or elsewhere.

Never a traceback; and what the models reject never passes: an error is reported at the mutation
or inside it. The models decide which mutations those are, so reader and models check each other.
"""

import copy
import io
import json
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

import labrun.protocols
from labrun.engine.check import check_text
from labrun.engine.language.source import parse_source, read_source
from labrun.engine.problems.print import print_problems
from labrun.schemas.protocol import Protocol

EXAMPLE = Path(__file__).parents[1] / "examples" / "libs_grid_scan.yaml"
SHIPPED = Path(labrun.protocols.__file__).parent
PROTOCOLS = [EXAMPLE, *sorted(p for p in SHIPPED.iterdir() if p.suffix in (".yaml", ".json"))]
STRUCTURAL, HARMLESS = 50, 20
"""How many mutants of each protocol are checked; the seed is fixed."""
LAYERS: list[Any] = [[], pytest.mark.soak, pytest.mark.slow, pytest.mark.soak]
"""In which layer of the suite a protocol's mutants are: the kinds of change are the same in each."""
OTHERS: list[Any] = [
    None, True, -1, 1.5, "", "text", "${{ x", "${{ steps }}", [], [[]], {}, {"a": {"b": 1}},
]  # fmt: skip
Place = tuple[Any, ...]


@dataclass(frozen=True)
class Mutant:
    """A changed protocol, how it was changed, and the places of the change."""

    data: Any
    how: str
    places: tuple[Place, ...]

    @property
    def is_structural(self) -> bool:
        """True if the models reject it."""
        try:
            Protocol.model_validate(self.data)
        except ValidationError:
            return True
        return False


def places(data: Any, path: Place = ()) -> list[Place]:
    held: Any = data.items() if isinstance(data, dict) else ()
    held = enumerate(data) if isinstance(data, list) else held
    return [path] * bool(path) + [p for key, value in held for p in places(value, (*path, key))]


def at(data: Any, path: Place) -> Any:
    for part in path:
        data = data[part]
    return data


def changed(data: Any, path: Place, change: Any) -> Any:
    """A copy in which `change(holder, key)` was applied to the parent of the node at a path."""
    other = copy.deepcopy(data)
    change(at(other, path[:-1]), path[-1])
    return other


def mutants(data: Any, chance: random.Random) -> Iterator[Mutant]:
    """Every node deleted, renamed, retyped, swapped with the next, moved and repeated."""
    every = places(data)
    for path in every:
        around, key = at(data, path[:-1]), path[-1]
        yield Mutant(changed(data, path, deleted), f"delete {path}", (path[:-1],))
        other = chance.choice(OTHERS)
        yield Mutant(changed(data, path, retyped(other)), f"{path} is {other!r}", (path,))
        if isinstance(key, str):
            yield Mutant(changed(data, path, renamed), f"rename {path}", (path[:-1],))
        keys = list(around) if isinstance(around, dict) else list(range(len(around)))
        if len(keys) > 1:
            beside = chance.choice([one for one in keys if one != key])
            told = (path, (*path[:-1], beside))
            yield Mutant(changed(data, path, swapped(beside)), f"swap {path}, {beside}", told)
        there = chance.choice(every)
        if there[: len(path)] != path and path[: len(there)] != there:
            value = copy.deepcopy(at(data, path))
            copied = changed(data, there, retyped(value))
            yield Mutant(copied, f"repeat {path} at {there}", (there,))
            if there[: len(path) - 1] != path[:-1]:  # deleting would shift its siblings
                moved = changed(copied, path, deleted)
                yield Mutant(moved, f"move {path} to {there}", (there, path[:-1]))


def deleted(around: Any, key: Any) -> None:
    del around[key]


def renamed(around: dict[str, Any], key: str) -> None:
    items = [(f"{k}x" if k == key else k, value) for k, value in around.items()]
    around.clear()
    around.update(items)


def retyped(value: Any) -> Any:
    def change(around: Any, key: Any) -> None:
        around[key] = copy.deepcopy(value)

    return change


def swapped(beside: Any) -> Any:
    def change(around: Any, key: Any) -> None:
        around[key], around[beside] = around[beside], around[key]

    return change


def sample(path: Path) -> list[Mutant]:
    """Mutants of one protocol: those that the models reject, and some that they accept."""
    chance = random.Random(f"{path.name} of old")
    source, problems = read_source(path)
    assert source is not None and not problems
    found = list(mutants(source.data, chance))
    refused = [mutant for mutant in found if mutant.is_structural]
    others = [mutant for mutant in found if not mutant.is_structural]
    some = chance.sample(refused, min(STRUCTURAL, len(refused)))
    return some + chance.sample(others, min(HARMLESS, len(others)))


def spots(text: str, mutant: Mutant) -> set[tuple[int, int]]:
    """Line and column of every key and value at and inside the mutation."""
    source, problems = parse_source(text, Path("mutant"), "mutant")
    assert source is not None, problems
    found = set()
    for place in mutant.places:
        inner = [place, *(p for p in places(source.data) if p[: len(place)] == place)]
        found |= {source.place(p, key=key)[:2] for p in inner for key in (False, True)}
    return found


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.stem, marks=LAYERS[number % len(LAYERS)])
        for number, path in enumerate(PROTOCOLS)
    ],
)
def test_a_mutant_is_told_where_it_differs_from_what_the_models_allow(path):
    for mutant in sample(path):
        text = json.dumps(mutant.data, indent=1)
        result = check_text(text, str(path.with_name("mutant.yaml")))
        print_problems(result.problems, file=io.StringIO())
        assert all(p.message and p.code for p in result.problems)
        if not mutant.is_structural:
            continue
        errors = {(p.line, p.column) for p in result.problems if p.severity == "error"}

        assert errors & spots(text, mutant), f"{mutant.how}: {result.problems}"


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=200))
def test_any_text_is_checked_without_a_traceback(text):
    assert check_text(text, "any.yaml").problems


@settings(max_examples=100, deadline=None)
@given(st.data())
def test_the_example_with_pieces_of_itself_in_other_places_is_checked(data):
    text = EXAMPLE.read_text(encoding="utf-8")
    start, end, there = (data.draw(st.integers(0, len(text))) for _ in range(3))
    mixed = text[:there] + text[min(start, end) : max(start, end)][:120] + text[there + 20 :]
    result = check_text(mixed, "mixed.yaml")
    print_problems(result.problems, file=io.StringIO())

    assert result.ok == (not any(p.severity == "error" for p in result.problems))
