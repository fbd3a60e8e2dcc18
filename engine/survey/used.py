"""`use`: open the other protocols that steps name, and bind their roles."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ...schemas import protocol as p
from ...schemas.problem import Problem
from ..lab.bind import BoundRole
from ..language.load import Loaded, read_protocol
from ..language.shape import Place
from ..language.source import LARGEST, Source, parse_source
from ..language.used_files import FileFault, find_file

DEEPEST = 20
MOST = 500
CODES = {
    "E120": "a used protocol that cannot be read",
    "E121": "a protocol that uses itself",
    "E122": "too many protocols within protocols",
}


@dataclass(slots=True)
class Opened:
    """A protocol with those that it uses, by the place of the `use` step."""

    source: Source
    loaded: Loaded
    folders: tuple[Path, ...]
    name: str = ""
    uses: "dict[Place, Opened]" = field(default_factory=dict)


class Opener:
    """Opens the protocols that a protocol uses, recursively; stops at circular use.

    `folders`: where files may lie that a protocol names, or below.
    """

    def __init__(self, folders: tuple[Path, ...]) -> None:
        self.folders = folders
        self.problems: list[Problem] = []
        self.count = 0

    def open(self, source: Source, loaded: Loaded, above: tuple[Path, ...] = ()) -> Opened:
        """The protocol with everything that it uses."""
        opened = Opened(source, loaded, self.folders)
        above = (*above, source.path.resolve())
        for step, place in uses_of(loaded.protocol):
            found = self._one(step, (*place, "use"), source, above)
            if found is not None:
                opened.uses[place] = found
        return opened

    def _one(
        self, step: p.Use, place: Place, source: Source, above: tuple[Path, ...]
    ) -> Opened | None:
        if "${{" in step.use:
            message = (
                "the file of a `use` must be known before the run: it cannot contain an expression"
            )
            return self._refuse(source, place, "E120", message, "choose the file with `if`")
        try:
            path, data = find_file(source.path, step.use, LARGEST, self.folders)
            text = data.decode("utf-8")
        except FileFault as fault:
            hint = f"looked for in {source.path.parent}"
            return self._refuse(source, place, "E120", str(fault), hint)
        except UnicodeDecodeError:
            return self._refuse(source, place, "E120", f"{step.use} is not UTF-8 text")
        if path.resolve() in above:
            way = [*above[above.index(path.resolve()) :], path]
            told = " uses ".join(one.name for one in way)
            return self._refuse(source, place, "E121", told, "a protocol cannot use itself")
        self.count += 1
        if len(above) > DEEPEST or self.count > MOST:
            message = f"more than {DEEPEST} protocols within each other, or {MOST} in all"
            return self._refuse(source, place, "E122", message)
        return self._read(text, path, above)

    def _read(self, text: str, path: Path, above: tuple[Path, ...]) -> Opened | None:
        inner, problems = parse_source(text, path, str(path))
        loaded = None
        if inner is not None:
            loaded, more = read_protocol(inner)
            problems += more
        self.problems += problems
        if inner is None or loaded is None:
            return None
        return self.open(inner, loaded, above)

    def _refuse(
        self, source: Source, place: Place, code: str, message: str, hint: str = ""
    ) -> None:
        self.problems.append(source.problem(place, code, message, hint))


def uses_of(protocol: p.Protocol) -> Iterator[tuple[p.Use, Place]]:
    """Every `use` of a protocol, with its place."""
    sections = {"on_resume": protocol.on_resume, "steps": protocol.steps}
    for name, steps in {**sections, "finally": protocol.finally_}.items():
        yield from _in_list(steps, (name,))


def _in_list(steps: list[Any], place: Place) -> Iterator[tuple[p.Use, Place]]:
    for index, step in enumerate(steps):
        yield from _in(step, (*place, index))


def _in(step: Any, here: Place) -> Iterator[tuple[p.Use, Place]]:
    if isinstance(step, list):
        yield from _in_list(step, here)
        return
    if isinstance(step, p.Use):
        yield step, here
    for key, inner in p.inner_lists(step):
        yield from _in_list(inner, (*here, key))
    yield from _in_list(step.fallback or [], (*here, "fallback"))
    for then, key in p.thens(step):
        yield from _in(then, (*here, *key))


def roles_for(
    step: p.Use, wanted: p.Protocol, roles: Mapping[str, BoundRole]
) -> dict[str, BoundRole]:
    """The devices that play the used protocol's roles: those named, or of the same name."""
    found = {}
    for role, contract in wanted.devices.items():
        bound = roles.get(step.devices.get(role, role))
        if bound is not None and bound.contract.keeps(contract):
            found[role] = replace(bound, role=role)
    return found
