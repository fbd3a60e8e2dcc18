"""Compile a protocol into its tree: one small subtree per body, not per point."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour

from ...schemas import protocol as p
from ...schemas.quantity import UnitError, seconds
from ..dispatch.dispatcher import Dispatcher
from ..language.expression import timed_steps
from ..language.own_functions import OwnFunction
from ..language.value import Value, value_of
from ..run.frame import Scope
from ..run.function_calls import LIMIT_S
from ..run.rows import Rows
from ..run.run import Run
from ..survey.survey import Survey, Used
from .legs import Legs
from .nodes.action import LOST_AT_MOST, ActionLeaf, ActionPlan
from .nodes.action_set import ActionSet
from .nodes.any_of import AnyOf
from .nodes.aside import Aside
from .nodes.background import Background, Join
from .nodes.branch import Branch
from .nodes.every_step import EveryStep
from .nodes.fallback import Alternative, Fallback
from .nodes.immediate import Fail, Log, Notify, Require, SetNames
from .nodes.in_order import InOrder
from .nodes.iterations import ConditionalIterations, CountedIterations, ItemIterations, Iterations
from .nodes.loop import Loop, LoopPlan
from .nodes.ordered import OrderedIterations
from .nodes.question import AskPerson
from .nodes.reserve import Reserve
from .nodes.retry import Retry, RetryRules
from .nodes.step import StepNode, StepRules
from .nodes.use import Use, UsePlan
from .nodes.wait import Wait, WaitUntil
from .nodes.watch import WatchedGroup, Watcher, WatchPlan

FIRST_TABLE = "data.csv"


@dataclass(frozen=True, slots=True)
class Place:
    """Where a step is compiled: its scope, its path inside the scope's frame, and its loop.

    `retry`: that of the set whose member it is.
    """

    scope: Scope
    path: str
    in_loop: bool
    question_id: str
    retry: int | p.Retry | None = None


@dataclass(slots=True)
class TreeCompiler:
    """Turns steps into nodes; `tables` are the CSV files that its loops write.

    `used` are the protocols that steps name. `within` is the path of the loops and uses that are
    being compiled; `used_in` is the place of a used protocol itself.
    """

    run: Run
    dispatcher: Dispatcher
    survey: Survey
    folder: Path
    tables: dict[str, Rows] = field(default_factory=dict)
    within: str = ""
    used_in: Place | None = None
    takes_first: bool = True
    """Whether `data.csv` is for this protocol: a used one leaves it to the rows of the outer protocol."""
    made: dict[str, Rows] = field(default_factory=dict)
    """The tables by the path of their loop."""
    used: dict[int, Used] = field(init=False)
    timed: set[str] = field(init=False)
    """The ids of which an expression asks when they began, or how long they took."""
    _is_finally: bool = False
    """Whether the steps of a `finally` are being compiled."""

    def __post_init__(self) -> None:
        # Two steps with the same text are two steps: they are distinguished as objects.
        self.used = {id(used.step): used for used in self.survey.used.values()}
        asked = [
            one
            for spot in self.survey.spots
            if isinstance(spot.value, Value)
            for one in spot.value.expressions()
        ]
        self.timed = {step for one in asked for step in timed_steps(one)}
        if any(one.live for one in asked):
            self.run.asks_clocks = True

    @property
    def defaults(self) -> p.Defaults:
        """What applies unless a step states otherwise."""
        return self.survey.protocol.defaults

    def _in_loop(self, place: Place) -> bool:
        """Whether a step is inside an iteration, including one of the protocol that uses this one."""
        return place.in_loop or (self.used_in is not None and self.used_in.in_loop)

    def sequence(
        self, steps: list[p.Step], scope: Scope, prefix: str = "", *, in_loop: bool = False,
        every: bool = False,
    ) -> Behaviour:  # fmt: skip
        """Steps in sequence; outside loops it waits for the background steps started in it."""
        joins = not in_loop and any(isinstance(s, p.Do | p.Group) and s.mode for s in steps)
        inner = Scope() if joins else scope
        children: list[Behaviour] = []
        for index, step in enumerate(steps):
            name = step.id or str(index)
            children.append(self.step(step, Place(inner, f"{prefix}{name}", in_loop, name)))
        body = (EveryStep if every else InOrder)(prefix or "steps", self.run, children)
        return Join(prefix or "steps", self.run, scope, inner, body) if joins else body

    def finals(self, steps: list[p.Step], scope: Scope) -> Behaviour:
        """The steps of a `finally`: each of them runs, whatever became of those before it."""
        self._is_finally = True
        try:
            return self.sequence(steps, scope, every=True)
        finally:
            self._is_finally = False

    def step(self, step: p.Step, place: Place) -> Behaviour:
        """One step with everything it states around its kind."""
        if isinstance(step, p.Do | p.Group) and step.mode == "background":
            return self._aside(step, place)
        ladder = self._ladder(step, place)
        return StepNode(self.run, place.scope, self._rules(step, place), ladder)

    def _rules(self, step: p.Step, place: Place) -> StepRules:
        total = None if isinstance(step, p.Do) else step.timeout
        return StepRules(
            segment=place.path,
            id=step.id,
            when=None if step.when is None else value_of(step.when),
            timeout_s=None if total is None else value_of(total),
            on_error=step.on_error or "stop",
            in_loop=self._in_loop(place),
            in_finally=self._is_finally,
            timed=step.id in self.timed,
        )

    def _aside(self, step: p.Do | p.Group, place: Place) -> Behaviour:
        rules = self._rules(step, place)
        later = StepRules(
            segment=place.path, id=step.id, on_error=rules.on_error, in_loop=True,
            timed=rules.timed, timeout_s=rules.timeout_s,
        )  # fmt: skip
        within = self.within

        def build(scope: Scope) -> Behaviour:
            inner = scope if isinstance(step, p.Do) else Scope()
            with self._in(within):
                there = Place(inner, place.path, place.in_loop, place.question_id)
                node = self._ladder(step, there)
            if inner is not scope:
                node = Aside(place.path, self.run, scope, inner, node)
            return StepNode(self.run, scope, later, node)

        begin = Background(place.path, self.run, place.scope, build)
        guard = StepRules(place.path, when=rules.when, in_loop=place.in_loop, silent=True)
        return StepNode(self.run, place.scope, guard, begin)

    # --- the ladder: retry, then fallback

    def _ladder(self, step: p.Step, place: Place) -> Behaviour:
        if not step.fallback:
            return self._retried(step, place)
        inner = Scope()
        primary = self._retried(step, replace(place, scope=inner))
        alternatives = [self._alternative(item, place) for item in step.fallback]
        return Fallback(place.path, self.run, primary, inner, alternatives, place.scope)

    def _alternative(self, item: p.Step | list[p.Step], place: Place) -> Alternative:
        scope = Scope()
        if isinstance(item, list):
            return Alternative(self.sequence(item, scope, in_loop=place.in_loop), scope)
        name = item.id or "0"
        node = self.step(item, Place(scope, name, place.in_loop, item.id or place.question_id))
        return Alternative(node, scope, asks=isinstance(item, p.Ask))

    def _retried(self, step: p.Step, place: Place) -> Behaviour:
        said = step.retry
        if said is None and isinstance(step, p.Do):
            said = self.defaults.retry
        if said is None or isinstance(step, p.Parallel | p.AnyOf):
            return self._kind(step, place)  # a set hands its retry to its members
        rules = retry_rules(said)
        if isinstance(step, p.Do):
            return Retry(place.path, self.run, rules, self._kind(step, place), place.scope, None)
        inner = Scope()
        there = Place(inner, place.path, place.in_loop, place.question_id)
        return Retry(place.path, self.run, rules, self._kind(step, there), place.scope, inner)

    # --- one method per kind

    def _kind(self, step: p.Step, place: Place) -> Behaviour:
        compilers: dict[str, Callable[[Any, Place], Behaviour]] = {
            "do": self._do,
            "parallel": self._parallel,
            "any": self._any,
            "foreach": self._foreach,
            "repeat": self._repeat,
            "while": self._while,
            "if": self._if,
            "use": self._use,
            "steps": self._group,
            "confirm": self._confirm,
            "ask": self._ask,
            "wait": self._wait,
            "set": self._set,
            "require": self._require,
            "log": self._log,
            "notify": self._notify,
            "fail": self._fail,
        }
        return compilers[step.KIND](step, place)

    def _do(self, step: p.Do, place: Place) -> Behaviour:
        return ActionLeaf(self.run, place.scope, self.dispatcher, self._action(step, place))

    def _action(self, step: p.Do, place: Place) -> ActionPlan:
        role_name, _, action_name = step.do.partition(".")
        role = self.survey.roles[role_name]
        timeout = step.timeout if step.timeout is not None else self.defaults.timeout
        retry = next(
            (r for r in (step.retry, self.defaults.retry, place.retry) if r is not None), None
        )
        on = None if retry is None else retry_rules(retry).on
        action = role.contract.actions[action_name]
        counted = retry is not None and action.effect != "once" and (on is None or "Lost" in on)
        return ActionPlan(
            segment=place.path,
            role=role,
            action_name=action_name,
            action=action,
            arguments=value_of(step.with_),
            timeout_s=None if timeout is None else value_of(timeout),
            on_unknown=step.on_unknown or "probe",
            lost_at_most=0 if counted else LOST_AT_MOST,
        )

    def _parallel(self, step: p.Parallel, place: Place) -> Behaviour:
        members = self._members(step, place)
        return ActionSet(place.path, self.run, members, cancel=step.on_failure == "cancel")

    def _any(self, step: p.AnyOf, place: Place) -> Behaviour:
        return AnyOf(place.path, self.run, place.scope, self._members(step, place))

    def _members(self, step: p.Parallel | p.AnyOf, place: Place) -> list[Behaviour]:
        members = []
        for index, member in enumerate(getattr(step, step.KIND)):
            name = member.id or str(index)
            there = Place(place.scope, f"{place.path}/{name}", place.in_loop, name)
            if step.retry is None:
                members.append(self.step(member, there))
            else:
                members.append(self._member_again(member, replace(there, retry=step.retry)))
        return members

    def _member_again(self, member: p.Step, place: Place) -> Behaviour:
        """A member of a set that is retried: only what failed is sent again."""
        assert place.retry is not None
        inner, rules = Scope(), retry_rules(place.retry)
        node = self.step(member, replace(place, scope=inner))
        return Retry(place.path, self.run, rules, node, place.scope, inner)

    def _foreach(self, step: p.Foreach, place: Place) -> Behaviour:
        ((name, items),) = step.foreach.items()
        key = None if step.key is None else value_of(step.key)
        if step.order != "shortest" or step.at_once is None:
            return self._loop(step, place, ItemIterations(name, value_of(items), key))
        legs, at_once = partial(Legs(self.survey).of, step.steps), value_of(step.at_once)
        turns = OrderedIterations(name, value_of(items), key, at_once, legs)
        return self._loop(step, place, turns)

    def _repeat(self, step: p.Repeat, place: Place) -> Behaviour:
        return self._loop(step, place, CountedIterations(value_of(step.repeat)))

    def _while(self, step: p.While, place: Place) -> Behaviour:
        most = None if step.max is None else value_of(step.max)
        return self._loop(step, place, ConditionalIterations(value_of(step.while_), most))

    def _loop(self, step: p.LoopBase, place: Place, turns: Iterations) -> Behaviour:
        rows = self._rows(step, place)
        within = f"{self.within}{place.path}/"

        def build() -> tuple[Scope, Behaviour]:
            scope = Scope()
            with self._in(within):
                return scope, self.sequence(step.steps, scope, in_loop=True)

        kept = step.keep_going
        plan = LoopPlan(
            segment=place.path,
            keeps_going=kept is not None,
            max_failed=None if kept is None else _value_or_none(kept.max_failed),
            in_a_row=None if kept is None else _value_or_none(kept.in_a_row),
            background=self.defaults.background,
            at_once=_value_or_none(step.at_once) if isinstance(step, p.Foreach) else None,
            nested=self._in_loop(place),
        )
        return Loop(self.run, place.scope, plan, turns, build, rows, self.dispatcher)

    @contextmanager
    def _in(self, within: str) -> Iterator[None]:
        """What is compiled here lies within these loops and uses."""
        outside, self.within = self.within, within
        try:
            yield
        finally:
            self.within = outside

    def _rows(self, step: p.LoopBase, place: Place) -> Rows | None:
        if step.collect is None:
            return None
        path = f"{self.within}{place.path}".replace("/", "-")
        if path in self.made:  # the body of an outer loop is compiled once for each at once
            return self.made[path]
        is_first = self.takes_first and FIRST_TABLE not in self.tables
        name = FIRST_TABLE if is_first else f"data-{path}.csv"
        columns: dict[str, Value | None] = {n: value_of(raw) for n, raw in step.collect.items()}
        self.tables[name] = self.made[path] = Rows(self.folder / name, columns)
        return self.tables[name]

    def _collects(self) -> bool:
        steps = (at.step for at in self.survey.steps)
        return any(isinstance(step, p.LoopBase) and step.collect for step in steps)

    def _group(self, step: p.Group, place: Place) -> Behaviour:
        if not step.reserve:
            return self._watched(step, place, in_loop=place.in_loop and step.mode is None)
        inner = Scope()
        there = Place(inner, place.path, place.in_loop, place.question_id)
        body = self._watched(step, there, in_loop=True)  # it joins what they do in the background
        devices = frozenset(self.survey.roles[role].device for role in step.reserve)
        return Reserve(place.path, self.run, place.scope, inner, body, self.dispatcher, devices)

    def _watched(self, step: p.Group, place: Place, *, in_loop: bool) -> Behaviour:
        body = self.sequence(step.steps, place.scope, f"{place.path}/", in_loop=in_loop)
        if not step.watch:
            return body
        watchers = [self._watch(one, n, place) for n, one in enumerate(step.watch, 1)]
        return WatchedGroup(place.path, self.run, place.scope, body, watchers)

    def _watch(self, watch: p.Watch, number: int, place: Place) -> Watcher:
        scope = Scope()
        look = None
        if watch.do is not None:
            look = self._action(p.Do.model_validate({"do": watch.do, "with": watch.with_}), place)
        then = None
        if watch.then != "pause":
            then = self.sequence(watch.steps, scope, in_loop=place.in_loop)
        plan = WatchPlan(
            number=number,
            when=value_of(watch.when),
            text=_text(watch.when),
            every=_value_or_none(watch.every),
            stale=_value_or_none(watch.stale),
            ignores_stale=watch.on_stale == "ignore",
            look=look,
            look_id=watch.id,
            leaves_running=watch.leaves_running,
            then=then,
            scope=scope,
        )
        self.run.watches_changes |= watch.every is None
        return Watcher(self.run, self.dispatcher, plan)

    def _if(self, step: p.If, place: Place) -> Behaviour:
        branches = [
            self.sequence(steps, place.scope, f"{place.path}/{name}/", in_loop=place.in_loop)
            for name, steps in (("then", step.then), ("else", step.else_))
            if steps
        ]
        then, otherwise = branches[0], branches[1] if len(branches) > 1 else None
        return Branch(place.path, self.run, place.scope, value_of(step.if_), then, otherwise)

    def _use(self, step: p.Use, place: Place) -> Behaviour:
        used = self.used[id(step)]
        within = f"{self.within}{place.path}/"
        here = replace(place, in_loop=self._in_loop(place))
        other = TreeCompiler(
            self.run, self.dispatcher, used.survey, self.folder, self.tables, within, here,
            takes_first=self.takes_first and not self._collects(), made=self.made,
        )  # fmt: skip
        protocol, inner = used.protocol, Scope()
        last = partial(other.finals, protocol.finally_) if protocol.finally_ else None
        plan = UsePlan(
            segment=place.path,
            arguments={name: value_of(raw) for name, raw in step.with_.items()},
            params=protocol.params,
            outputs={name: value_of(raw) for name, raw in protocol.outputs.items()},
            tables=used.survey.tables,
            last=last,
            last_steps=protocol.finally_,
            on_resume=partial(_on_resume, used.survey, within) if protocol.on_resume else None,
        )
        return Use(self.run, place.scope, inner, plan, other.sequence(protocol.steps, inner))

    def _confirm(self, step: p.Confirm, place: Place) -> Behaviour:
        return AskPerson(
            place.path, self.run, place.scope, value_of(step.confirm), p.CONFIRM_CHOICES,
            question_id=place.question_id, confirm=True,
        )  # fmt: skip

    def _ask(self, step: p.Ask, place: Place) -> Behaviour:
        return AskPerson(
            place.path, self.run, place.scope, value_of(step.ask), step.choices,
            question_id=place.question_id, confirm=False,
        )  # fmt: skip

    def _wait(self, step: p.Wait, place: Place) -> Behaviour:
        if step.until is not None:
            return WaitUntil(place.path, self.run, place.scope, value_of(step.until))
        return Wait(place.path, self.run, place.scope, value_of(step.wait))

    def _set(self, step: p.Set, place: Place) -> Behaviour:
        own = self.survey.own_names
        values = {name: value_of(raw, own) for name, raw in step.set.items()}
        called = {n for value in values.values() for one in value.expressions() for n in one.calls}
        functions = {
            name: function
            for name in called
            if isinstance(function := self.survey.functions.get(name), OwnFunction)
        }
        limit_s = LIMIT_S if step.timeout is None else _behind(step.timeout)
        return SetNames(place.path, self.run, place.scope, values, functions, limit_s)

    def _require(self, step: p.Require, place: Place) -> Behaviour:
        return Require(
            place.path, self.run, place.scope, value_of(step.require), _text(step.require)
        )

    def _log(self, step: p.Log, place: Place) -> Behaviour:
        return Log(place.path, self.run, place.scope, value_of(step.log))

    def _notify(self, step: p.Notify, place: Place) -> Behaviour:
        picture = _value_or_none(step.picture)
        return Notify(place.path, self.run, place.scope, value_of(step.notify), picture)

    def _fail(self, step: p.Fail, place: Place) -> Behaviour:
        return Fail(place.path, self.run, place.scope, value_of(step.fail))


def _on_resume(survey: Survey, within: str, compiler: TreeCompiler, scope: Scope) -> Behaviour:
    """The `on_resume` of a used protocol, which the protocol that is run takes up."""
    own = TreeCompiler(
        compiler.run, compiler.dispatcher, survey, compiler.folder, compiler.tables,
        f"{within}on_resume/", takes_first=False, made=compiler.made,
    )  # fmt: skip
    return own.sequence(survey.protocol.on_resume, scope)


def _behind(timeout: p.Duration) -> float:
    """A limit that comes only after the step's own timeout."""
    try:
        return seconds(timeout) + 0.5
    except UnitError:  # computed in the run
        return math.inf


def _text(condition: Any) -> str:
    """A condition as it is written, without its braces."""
    return str(condition).strip().removeprefix("${{").removesuffix("}}").strip()


def _value_or_none(raw: int | float | str | None) -> Value | None:
    return None if raw is None else value_of(raw)


def retry_rules(said: int | p.Retry) -> RetryRules:
    """`retry: 3`, or the long form, as rules."""
    if isinstance(said, int):
        return RetryRules(attempts=said)
    return RetryRules(
        attempts=said.attempts,
        wait_s=seconds(said.wait),
        factor=said.factor,
        max_wait_s=None if said.max_wait is None else seconds(said.max_wait),
        jitter=said.jitter,
        on=None if said.on is None else frozenset(said.on),
    )
