"""The scope of an expression: where it is in a protocol, and which names it may use there."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from keyword import kwlist
from typing import Any, Literal

from ...schemas.quantity import COMMON, PLAIN
from ..lab.bind import BoundRole
from ..language.column import TableFault
from ..language.expression import CONSTANTS, STATUS
from ..language.fold import Folding
from ..language.functions import FUNCTIONS
from ..language.functions import RESERVED as RESERVED_FUNCTIONS
from ..language.infer import Fault
from ..language.own_functions import FunctionFault, OwnFunction
from ..language.shape import Place
from ..language.suggest import did_you_mean
from ..language.table import Tables
from ..language.types import ANY, ERROR, RUN, Type, either, type_of_schema

OPEN = ("member", "branch")
"""Levels whose steps are visible after them, with a null result if they did not run."""
RESERVED = {"params", "steps", "run", "error", *CONSTANTS, *RESERVED_FUNCTIONS, *kwlist}


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """A part of the protocol that hides its contents: a loop, a fallback, a phase.

    A member of a set and a branch of an `if` hide theirs only from their siblings, which have the
    same `group`.
    """

    kind: Literal["phase", "loop", "fallback", "watch", "aside", "member", "branch"]
    name: str
    group: Place = ()


@dataclass(frozen=True, slots=True)
class Declared:
    """A step with an id: where it is, when it runs, what it returns."""

    id: str
    order: int
    levels: tuple[Level, ...]
    type: Type
    background: bool
    place: Place


@dataclass(frozen=True, slots=True)
class LoopName:
    """The name of a loop's item; `items` if they are known before the run."""

    name: str
    type: Type
    items: Sequence[Any] | None
    level: Level


@dataclass(frozen=True, slots=True)
class SetName:
    """A name that a `set` defines; its value is known before the run if `known` is true."""

    name: str
    type: Type
    order: int
    levels: tuple[Level, ...]
    known: bool
    value: Any


class Declarations:
    """What a protocol declares, in the order of a walk over it."""

    raw_names: set[str]
    set_counts: Mapping[str, int]
    values: Mapping[str, Any]
    params: dict[str, Type]
    ids: dict[str, Declared]
    sets: list[SetName]
    loops: list[LoopName]
    tables: Tables
    roles: Mapping[str, BoundRole]
    functions: Mapping[str, OwnFunction | FunctionFault]
    own_names: frozenset[str]
    """Of its own functions, also of those that cannot be used."""
    _order = 0

    @cached_property
    def status(self) -> Type:
        """What `status` is in expressions: the status of each role's device, by its contract."""
        known = {
            name: type_of_schema(bound.contract.status) if bound.contract.status else ANY
            for name, bound in self.roles.items()
        }
        return Type("map", fields=known, rest=None if known else ANY)

    def tick(self) -> int:
        """The next moment in the order of the protocol."""
        self._order += 1
        return self._order


@dataclass(frozen=True, slots=True)
class Env:
    """The scope of an expression, with the names that it may use; implements `infer.Names`."""

    survey: "Declarations"
    order: int
    levels: tuple[Level, ...]
    loops: tuple[LoopName, ...] = ()
    late: bool = False

    def inside(self, level: Level, *loops: LoopName) -> "Env":
        """The same place, one level further in."""
        return Env(self.survey, self.survey.tick(), (*self.levels, level), (*self.loops, *loops))

    def now(self, *, late: bool = False) -> "Env":
        """The same levels, one moment later; `late` where background results are known."""
        return Env(self.survey, self.survey.tick(), self.levels, self.loops, late)

    @property
    def in_fallback(self) -> bool:
        """True where a failure has a name: `error`."""
        return any(level.kind in ("fallback", "watch") for level in self.levels)

    def visible(self, levels: tuple[Level, ...]) -> bool:
        """True where names declared at these levels are visible from here."""
        if not levels or levels == self.levels:
            return True
        return not self._sibling(levels) and all(
            level in self.levels or level.kind in OPEN for level in levels
        )

    def set_names(self) -> dict[str, list[SetName]]:
        """The `set` names that have a value here."""
        found: dict[str, list[SetName]] = {}
        for name in self.survey.sets:
            if name.order < self.order and self.visible(name.levels):
                found.setdefault(name.name, []).append(name)
        return found

    # --- used by infer

    def name(self, name: str) -> Type | Fault:
        """The type of a name, or why it has none here."""
        for loop in reversed(self.loops):
            if loop.name == name:
                return loop.type
        sets = self.set_names()
        if name in sets:
            return either([one.type for one in sets[name]])
        if name == "run":
            return RUN
        if name == STATUS:
            return self.survey.status
        if name == "error":
            hint = "in a `fallback`, `error` says why the step failed; in a watch's `then`, what was seen"
            return (
                ERROR
                if self.in_fallback
                else Fault("E311", "error is available only in a fallback or a watch", hint)
            )
        return self._unknown(name, sets)

    def _unknown(self, name: str, sets: Mapping[str, Any]) -> Type | Fault:
        for loop in self.survey.loops:
            if loop.name == name:
                message = f"{name} is known only inside the loop {loop.level.name}"
                return Fault("E306", message)
        if any(one.name == name for one in self.survey.sets):
            return Fault(
                "E305",
                f"{name} has no value yet: its `set` comes later, or inside a loop or fallback",
            )
        if name in self.survey.raw_names:
            return (
                ANY
                if name not in self.survey.ids
                else Fault("E302", f"there is no name {name}; did you mean steps.{name}?")
            )
        if name in FUNCTIONS:
            return Fault("E302", f"{name} is a function; call it: {name}(...)")
        known = [
            *(loop.name for loop in self.loops),
            *sets,
            "run",
            *(["error"] if self.in_fallback else []),
        ]
        if name in self.survey.params:
            return Fault("E302", f"there is no name {name}; did you mean params.{name}?")
        guess = did_you_mean(name, [*known, "params", "steps"])
        if name in self.survey.roles:
            way = f"what a device tells is status.{name}.FIELD, and what an action returned steps.ID.FIELD"
            return Fault("E302", f"there is no name {name}: it is a role", way)
        way = f"text needs quotes: '{name}'"
        if name in (*PLAIN, *COMMON):
            way = f"a unit stands behind a number: 1 {name}"
        return Fault("E302", f"there is no name {name}{guess}", way)

    def param(self, name: str) -> Type | Fault:
        """The type of a parameter."""
        if name in self.survey.params:
            return self.survey.params[name]
        known = self.survey.params
        hint = f"the protocol has {', '.join(known)}" if known else "the protocol has no `params`"
        return Fault(
            "E303",
            f"params.{name}: there is no parameter {name}{did_you_mean(name, known, prefix='params.')}",
            hint,
        )

    def step(self, name: str) -> Type | Fault:
        """The type of a step's result, or why it has none here."""
        declared = self.survey.ids.get(name)
        if declared is None and name in self.survey.raw_names:
            return ANY
        if declared is None:
            guess = did_you_mean(name, self.survey.ids, prefix="steps.")
            known = (
                f"ids: {', '.join(self.survey.ids)}" if self.survey.ids else "give a step an `id:`"
            )
            return Fault("E304", f"steps.{name}: no step has the id {name!r}{guess}", known, name)
        for level in declared.levels:
            if level not in self.levels and level.kind not in OPEN:
                return self._hidden(name, level)
        beside = self._sibling(declared.levels)
        if beside is not None:
            why = (
                "is in the same set and starts together with this one"
                if beside.kind == "member"
                else f"runs only in the other branch, `{beside.name}`"
            )
            return Fault("E305", f"steps.{name}: {name!r} {why}", step=name)
        if declared.order >= self.order:
            message = f"steps.{name}: {name!r} has not run yet at this point"
            return Fault("E305", message, "use a result after its step", name)
        if declared.background and not self.late:
            hint = "leave out `mode: background`, or use it in `collect` or `outputs`"
            return Fault(
                "E310",
                f"steps.{name}: {name!r} runs in the background; its result is not known here",
                hint,
            )
        return declared.type

    def _hidden(self, name: str, level: Level) -> Fault:
        where = {
            "loop": f"exists only inside the loop {level.name}; `collect` keeps values of iterations",
            "fallback": f"exists only within the fallback of {level.name}",
            "aside": f"exists only inside {level.name}, which runs in the background",
            "watch": f"exists only within a watch of {level.name}",
            "phase": f"runs in `{level.name}` and is not known here",
        }[level.kind]
        return Fault("E306", f"steps.{name}: {name!r} {where}")

    def _sibling(self, levels: tuple[Level, ...]) -> Level | None:
        """The other member of the set, or the other branch, that contains these levels."""
        here = {level.group: level for level in self.levels if level.kind in OPEN}
        beside = (one for one in levels if one.kind in OPEN and here.get(one.group, one) is not one)
        return next(beside, None)

    def table(self, file: str, kinds: Mapping[str, str]) -> Type | Fault:
        """The type of a table beside the protocol."""
        try:
            return self.survey.tables(file, **kinds).type
        except TableFault as fault:
            return Fault("E313", str(fault))

    def function(self, name: str) -> OwnFunction | None:
        """The protocol's own function of this name; None if it cannot be used, which is reported."""
        found = self.survey.functions.get(name)
        return found if isinstance(found, OwnFunction) else None

    # --- used by fold

    def folding(self) -> Folding:
        """The names whose values are known before the run."""
        known = {
            name: found[0].value
            for name, found in self.set_names().items()
            if len(found) == 1 and found[0].known and self.survey.set_counts[name] == 1
        }
        loops = {loop.name: loop.items for loop in self.loops}
        return Folding(self.survey.values, {**known, "csv": self.survey.tables}, loops)
