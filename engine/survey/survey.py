"""Walk a protocol once, in the order in which it runs, and record what is where."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ...schemas import protocol as p
from ...schemas.contract import Action
from ..lab.bind import BoundRole
from ..language.expression import ExpressionError
from ..language.fold import fold
from ..language.load import Broken
from ..language.own_functions import read_functions
from ..language.shape import Place
from ..language.source import Source
from ..language.suggest import closest
from ..language.table import Tables
from ..language.types import (  # fmt: skip
    ANY,
    LOOP_RESULT,
    NULL,
    Type,
    chosen,
    either,
    type_of_param,
    type_of_schema,
)
from ..params.params import ParamFault, given_value, take
from .scope import Declarations, Declared, Env, Level, LoopName, SetName
from .spots import Spot, StepAt, Use
from .used import Opened, roles_for


def raw_names(data: Any, whole: bool) -> tuple[set[str], Counter[str]]:
    """Every id and name of a loop or `set` in the file, even in steps that could not be read.

    Their problems are not reported again for expressions that use them; unless the file was read `whole`,
    neither is a key such as `sset` or `id:stay`, once for each use of the name. Also returns how often each
    name is `set`.
    """
    found: set[str] = set()
    counts: Counter[str] = Counter()
    left = [data]
    while left:
        here = left.pop()
        if isinstance(here, list):
            left += here
        elif isinstance(here, dict):
            left += here.values()
            for written, value in here.items():
                key = written if whole or not isinstance(written, str) else _naming(written)
                if key == "id" and isinstance(value, str):
                    found.add(value)
                elif key in ("set", "foreach") and isinstance(value, dict):
                    found.update(value)
                    counts.update(list(value) if key == "set" else ())
                elif isinstance(key, str) and key.startswith("id:"):
                    found.add(key.removeprefix("id:"))
    return found, counts


@cache
def _naming(key: str) -> str:
    """The key that gives a name, where this one looks like it."""
    return closest(key, ("id", "set", "foreach")) or key


@dataclass(slots=True)
class Used:
    """One `use`: the protocol it runs, its devices, and what is known about it."""

    step: p.Use
    opened: Opened
    roles: Mapping[str, BoundRole]
    values: Mapping[str, Any]
    survey: "Survey"

    @property
    def name(self) -> str:
        """The name of the file in problems."""
        return self.opened.source.name

    @property
    def path(self) -> Path:
        """The file."""
        return self.opened.source.path

    @property
    def source(self) -> Source:
        """The content of the file."""
        return self.opened.source

    @property
    def protocol(self) -> p.Protocol:
        """The protocol in the file."""
        return self.opened.loaded.protocol


class Survey(Declarations):
    """Everything that the checks need to know about a protocol, from one walk over it."""

    def __init__(
        self, opened: Opened, roles: Mapping[str, BoundRole], values: Mapping[str, Any]
    ) -> None:
        source, protocol = opened.source, opened.loaded.protocol
        self.protocol, self.roles, self.values = protocol, roles, values
        self.source, self.opened = source, opened
        self.tables = Tables(source.path, opened.folders)
        self.functions = dict(read_functions(protocol.functions, source.path, opened.folders))
        self.own_names = frozenset({*protocol.functions, *source.names("functions")})
        self.raw_names, self.set_counts = raw_names(source.data, opened.loaded.whole)
        self.params: dict[str, Type] = dict.fromkeys(source.names("params"), ANY)
        self.params |= {name: type_of_param(param) for name, param in protocol.params.items()}
        self.ids: dict[str, Declared] = {}
        self.twice: list[tuple[str, Place, Place]] = []
        self.sets: list[SetName] = []
        self.loops: list[LoopName] = []
        self.spots: list[Spot] = []
        self.steps: list[StepAt] = []
        self.used: dict[Place, Used] = {}
        self._walk()

    def action(self, step: p.Do) -> tuple[BoundRole, Action] | None:
        """The device that a `do` addresses and its action; None where either is unknown."""
        role, _, name = step.do.partition(".")
        bound = self.roles.get(role)
        if bound is None or name not in bound.contract.actions:
            return None
        return bound, bound.contract.actions[name]

    def actions(self) -> Iterator[tuple[p.Do, StepAt, BoundRole, Action]]:
        """Every `do` whose action is known."""
        for at in self.steps:
            if isinstance(at.step, p.Do) and (found := self.action(at.step)) is not None:
                yield at.step, at, *found

    def _walk(self) -> None:
        protocol = self.protocol
        resume = Env(self, self.tick(), (Level("phase", "on_resume"),))
        self._sequence(protocol.on_resume, ("on_resume",), resume)
        main = Env(self, self.tick(), ())
        if protocol.defaults.timeout is not None:
            self._spot(
                ("defaults", "timeout"), protocol.defaults.timeout, "duration", main, "timeout"
            )
        self._sequence(protocol.steps, ("steps",), main)
        after = Env(self, self.tick(), (Level("phase", "finally"),), late=True)
        self._sequence(protocol.finally_, ("finally",), after)
        end = main.now(late=True)
        for name, raw in protocol.outputs.items():
            self._spot(("outputs", name), raw, "output", end, name)

    def _spot(self, place: Place, raw: Any, use: Use, env: Env, what: str) -> Spot:
        spot = Spot(place, raw, use, env, what)
        self.spots.append(spot)
        return spot

    def _sequence(self, steps: Sequence[Any], place: Place, env: Env) -> Type:
        result = NULL
        for index, step in enumerate(steps):
            result = self._step(step, (*place, index), env)
        return result

    def _step(self, step: p.StepBase, place: Place, env: Env) -> Type:
        here = env.now()
        arguments: dict[str, Spot] = {}
        self.steps.append(StepAt(step, place, here, arguments))
        if step.when is not None:
            self._spot((*place, "when"), step.when, "condition", here, "when")
        if step.timeout is not None:
            self._spot((*place, "timeout"), step.timeout, "duration", here, "timeout")
        result = self._kind(step, place, here, arguments)
        name = step.id or f"step {place[-1] + 1 if isinstance(place[-1], int) else place[-1]}"
        for index, alternative in enumerate(step.fallback or []):
            inner = here.inside(Level("fallback", name))
            at = (*place, "fallback", index)
            if isinstance(alternative, list):
                self._sequence(alternative, at, inner)
            else:
                self._step(alternative, at, inner)
        if step.id is not None:
            self._declare(step, step.id, place, env, result)
        return result

    def _declare(self, step: p.StepBase, name: str, place: Place, env: Env, result: Type) -> None:
        if name in self.ids:
            self.twice.append((name, place, self.ids[name].place))
            return
        background = isinstance(step, p.Do | p.Group) and step.mode == "background"
        self.ids[name] = Declared(name, self.tick(), env.levels, result, background, place)

    def _kind(self, step: p.StepBase, place: Place, env: Env, arguments: dict[str, Spot]) -> Type:
        if isinstance(step, p.Do):
            return self._do(step, place, env, arguments)
        if isinstance(step, p.Parallel | p.AnyOf):
            return self._set_of_actions(step, place, env)
        if isinstance(step, p.Foreach):
            return self._loop(step, place, env)
        if isinstance(step, p.Repeat | p.While):
            return self._iterations(step, place, env)
        if isinstance(step, p.If):
            return self._if(step, place, env)
        if isinstance(step, p.Use):
            return self._use(step, place, env, arguments)
        if isinstance(step, p.Group):
            return self._group(step, place, env)
        if isinstance(step, p.Set):
            return self._set(step, place, env)
        return self._simple(step, place, env)

    def _group(self, step: p.Group, place: Place, env: Env) -> Type:
        if step.mode is not None:
            env = env.inside(Level("aside", step.id or "the group"))
        result = self._sequence(step.steps, (*place, "steps"), env)
        for index, watch in enumerate(step.watch or []):
            at = (*place, "watch", index)
            self._watch(watch, at, env.inside(Level("watch", step.id or "the group")))
        return result

    def _watch(self, watch: p.Watch, place: Place, env: Env) -> None:
        for key in ("every", "stale"):
            if getattr(watch, key) is not None:
                self._spot((*place, key), getattr(watch, key), "duration", env, key)
        if watch.do is not None:
            look = p.Do.model_validate({"do": watch.do, "with": watch.with_})
            arguments: dict[str, Spot] = {}
            self.steps.append(StepAt(look, place, env, arguments))
            read = self._do(look, place, env, arguments)
            if watch.id is not None:
                self._declare(look, watch.id, place, env, read)
        inner = env.now()
        self._spot((*place, "when"), watch.when, "condition", inner, "when")
        if isinstance(watch.then, list):
            self._sequence(watch.then, (*place, "then"), inner)
        elif isinstance(watch.then, p.StepBase):
            self._step(watch.then, (*place, "then"), inner)

    def _simple(self, step: p.StepBase, place: Place, env: Env) -> Type:
        uses: dict[str, Use] = {
            "confirm": "text", "ask": "text", "log": "text", "fail": "text", "wait": "duration",
            "notify": "text",
            "require": "condition",
        }  # fmt: skip
        use = uses.get(step.KIND)
        if isinstance(step, p.Wait) and step.until is not None:
            self._spot((*place, "wait", "until"), step.until, "moment", env, "until")
        elif use is not None:
            self._spot((*place, step.KIND), getattr(step, step.KIND), use, env, step.KIND)
        if isinstance(step, p.Notify) and step.picture is not None:
            self._spot((*place, "picture"), step.picture, "text", env, "picture")
        if isinstance(step, Broken):
            return ANY
        if isinstance(step, p.Confirm | p.Ask):
            choices = p.CONFIRM_CHOICES if isinstance(step, p.Confirm) else step.choices
            return chosen([] if step.fallback else choices)
        return NULL

    def _do(self, step: p.Do, place: Place, env: Env, arguments: dict[str, Spot]) -> Type:
        for name, raw in step.with_.items():
            arguments[name] = self._spot((*place, "with", name), raw, "argument", env, name)
        found = self.action(step)
        return type_of_schema(found[1].returns, root=True) if found is not None else ANY

    def _set_of_actions(self, step: p.Parallel | p.AnyOf, place: Place, env: Env) -> Type:
        results = []
        for index, member in enumerate(getattr(step, step.KIND)):
            inner = env.inside(Level("member", str(index), place))
            results.append(self._step(member, (*place, step.KIND, index), inner))
        found = either(results)
        return Type("list", item=found) if isinstance(step, p.Parallel) else found

    def _if(self, step: p.If, place: Place, env: Env) -> Type:
        self._spot((*place, "if"), step.if_, "condition", env, "if")
        results = [NULL]
        for name, steps in (("then", step.then), ("else", step.else_ or [])):
            inner = env.inside(Level("branch", name, place))
            results.append(self._sequence(steps, (*place, name), inner))
        return either(results)

    def _use(self, step: p.Use, place: Place, env: Env, arguments: dict[str, Spot]) -> Type:
        for name, raw in step.with_.items():
            arguments[name] = self._spot((*place, "with", name), raw, "argument", env, name)
        opened = self.opened.uses.get(place)
        if opened is None:
            return ANY
        wanted = opened.loaded.protocol
        roles = roles_for(step, wanted, self.roles)
        values = dict(_known_values(wanted, arguments))
        used = Used(step, opened, roles, values, Survey(opened, roles, values))
        self.used[place] = used
        outputs = {s.what: s.inferred()[0] for s in used.survey.spots if s.use == "output"}
        return Type("map", fields=outputs)

    def _set(self, step: p.Set, place: Place, env: Env) -> Type:
        types: dict[str, Type] = {}
        for name, raw in step.set.items():
            spot = self._spot((*place, "set", name), raw, "set", env, name)
            types[name] = spot.inferred()[0]
            spot._inferred = None  # inferred again when every id is known
            value = (
                fold(spot.value, env.folding()) if not env.levels and step.when is None else None
            )
            known = value is not None and value.known and not value.loops
            found = value.value if value is not None and known else None
            self.sets.append(SetName(name, types[name], self.tick(), env.levels, known, found))
        return Type("map", fields=types)

    def _loop(self, step: p.Foreach, place: Place, env: Env) -> Type:
        ((name, raw),) = step.foreach.items()
        spot = self._spot((*place, "foreach", name), raw, "items", env, name)
        kind = spot.inferred()[0]
        spot._inferred = None
        folded = fold(spot.value, env.folding())
        constant = folded.known and not folded.loops and isinstance(folded.value, Sequence)
        items = folded.value if constant and not isinstance(folded.value, str) else None
        level = Level("loop", step.id or name)
        loop = LoopName(name, (kind.item or ANY) if kind.kind == "list" else ANY, items, level)
        self.loops.append(loop)
        inner = env.inside(level, loop)
        if step.key is not None:
            self._spot((*place, "key"), step.key, "key", inner, "key")
        if step.at_once is not None:
            self._spot((*place, "at_once"), step.at_once, "count", env, "at_once")
        return self._body(step, place, env, inner)

    def _iterations(self, step: p.Repeat | p.While, place: Place, env: Env) -> Type:
        if isinstance(step, p.Repeat):
            self._spot((*place, "repeat"), step.repeat, "count", env, "repeat")
        else:
            self._spot((*place, "while"), step.while_, "condition", env, "while")
            if step.max is not None:
                self._spot((*place, "max"), step.max, "count", env, "max")
        level = Level("loop", step.id or step.KIND)
        return self._body(step, place, env, env.inside(level))

    def _body(self, step: p.LoopBase, place: Place, env: Env, inner: Env) -> Type:
        if step.keep_going is not None:
            for key in ("max_failed", "in_a_row"):
                limit = getattr(step.keep_going, key)
                if limit is not None:
                    self._spot((*place, "keep_going", key), limit, "count", env, key)
        self._sequence(step.steps, (*place, "steps"), inner)
        late = inner.now(late=True)
        for column, value in (step.collect or {}).items():
            self._spot((*place, "collect", column), value, "collect", late, column)
        return LOOP_RESULT


def _known_values(wanted: p.Protocol, arguments: Mapping[str, Spot]) -> Iterator[tuple[str, Any]]:
    """The parameters of a used protocol that are known before the run, at this place."""
    for name, param in wanted.params.items():
        spot = arguments.get(name)
        if spot is None:
            given = param.default
        else:
            folded = fold(spot.value, spot.env.folding())
            given = given_value(folded.value) if folded.known and not folded.loops else None
        if given is None:
            continue
        with suppress(ParamFault, ExpressionError):  # reported by the family `uses`
            yield name, take(name, param, given, written=True)
