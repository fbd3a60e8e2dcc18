"""`use`: another protocol, opened where a step names it, and what is made of it there."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...schemas import protocol as p
from ...schemas.problem import Problem
from ..bind import BoundRole
from .load import Loaded, read_protocol
from .shape import Place
from .source import LARGEST, Source, parse_source
from .used_files import FileFault, find_file

if TYPE_CHECKING:
    from .survey import Survey

DEEPEST = 20
MOST = 500
CODES = {
    "E120": "a protocol that is used and cannot be read",
    "E121": "a protocol that uses itself",
    "E122": "protocols within protocols without end",
}


@dataclass(slots=True)
class Opened:
    """A protocol with those that it uses, by the place of the step that names them."""

    source: Source
    loaded: Loaded
    name: str = ""
    uses: "dict[Place, Opened]" = field(default_factory=dict)


@dataclass(slots=True)
class Used:
    """One `use`: whose steps it stands for, with which devices, and what is known of them."""

    step: p.Use
    opened: Opened
    roles: Mapping[str, BoundRole]
    values: Mapping[str, Any]
    survey: "Survey"

    @property
    def name(self) -> str:
        """The file as problems name it."""
        return self.opened.source.name

    @property
    def path(self) -> Path:
        """The file."""
        return self.opened.source.path

    @property
    def source(self) -> Source:
        """What stands in it."""
        return self.opened.source

    @property
    def protocol(self) -> p.Protocol:
        """What it says."""
        return self.opened.loaded.protocol


class Opening:
    """Opens what a protocol uses, and what that uses, once a file; ends where it goes in circles."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []
        self.count = 0

    def open(self, source: Source, loaded: Loaded, above: tuple[Path, ...] = ()) -> Opened:
        """The protocol with everything that it uses."""
        opened = Opened(source, loaded)
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
            message = "the file of a `use` is known before the run: it holds no expression"
            return self._refuse(source, place, "E120", message, "choose with `if`")
        try:
            path, data = find_file(source.path, step.use, LARGEST)
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
        here = (*place, index)
        if isinstance(step, list):
            yield from _in_list(step, here)
            continue
        if isinstance(step, p.Use):
            yield step, here
        for key, inner in p.inner_lists(step):
            yield from _in_list(inner, (*here, key))
        yield from _in_list(step.fallback or [], (*here, "fallback"))


def roles_for(
    step: p.Use, wanted: p.Protocol, roles: Mapping[str, BoundRole]
) -> dict[str, BoundRole]:
    """The devices that play the other protocol's roles: those named, or of the same name."""
    found = {}
    for role, contract in wanted.devices.items():
        bound = roles.get(step.devices.get(role, role))
        if bound is not None and bound.contract.type == contract:
            found[role] = replace(bound, role=role)
    return found
