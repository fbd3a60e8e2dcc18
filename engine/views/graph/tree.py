"""The nodes of a protocol's tree: one per step, with its guard, fallback and retry around it."""

from collections.abc import Sequence
from textwrap import wrap
from typing import Any

from ....schemas import protocol as p
from ...language.shape import Place
from ..english import bare, count_of, items_text, joined, shortened
from ..forecast import Outlook
from .node import Kind, Node

LINE = 44


def phases(view: Outlook) -> dict[str, Node]:
    """Title -> tree, for what runs on resume, the protocol itself, and its `finally`."""
    protocol, tree = view.protocol, Tree()
    found = {protocol.name: tree.sequence(view, protocol.steps, ("steps",), "", protocol.name)}
    if protocol.on_resume:
        steps = protocol.on_resume
        found["on_resume"] = tree.sequence(view, steps, ("on_resume",), "", "on_resume")
    if protocol.finally_:
        found["finally"] = tree.sequence(view, protocol.finally_, ("finally",), "", "finally")
    return found


class Tree:
    """Makes the nodes, in the order and with the paths of the compiled tree."""

    def sequence(
        self, view: Outlook, steps: Sequence[Any], place: Place, prefix: str, name: str = ""
    ) -> Node:
        """Steps in sequence."""
        below = [
            self.step(before, step, here, prefix + (step.id or str(here[-1])))
            for before, step, here in view.along(steps, place)
        ]
        return Node("sequence", _lines("Sequence", name), below)

    def step(self, view: Outlook, step: Any, place: Place, path: str) -> Node:
        """One step with everything it states around its kind."""
        node = self._kind(view, step, place, path)
        node.step = path
        said = step.retry
        if said is None and isinstance(step, p.Do):
            said = view.protocol.defaults.retry
        if isinstance(step, p.Parallel | p.AnyOf):
            node.below = [_retried(member, said) for member in node.below]
        else:
            node = _retried(node, said)
        if p.watches(step):
            node = self._watched(view, step, place, node)
        if step.fallback:
            others = [
                self._alternative(view, one, (*place, "fallback", index))
                for index, one in enumerate(step.fallback)
            ]
            for number, other in enumerate(others, 1):
                other.edge = f"else {number}" if len(others) > 1 else "else"
            node = Node("fallback", ("Selector", "fallback"), [node, *others])
        guard = _guard(step)
        return Node("guard", guard, [node]) if guard else node

    def _watched(self, view: Outlook, step: Any, place: Place, node: Node) -> Node:
        below = [node]
        for number, watch in enumerate(p.watches(step)):
            then = Node("instant", ("Pause",))
            if watch.then != "pause":
                then = self._alternative(view, watch.then, (*place, "watch", number, "then"))
            then.edge = f"when {shortened(bare(watch.when))}"
            below.append(then)
        return Node("guard", ("Watched",), below)

    def _alternative(self, view: Outlook, one: Any, place: Place) -> Node:
        if isinstance(one, list):
            return self.sequence(view, one, place, "")
        return self.step(view, one, place, one.id or "0")

    def _kind(self, view: Outlook, step: Any, place: Place, path: str) -> Node:
        if isinstance(step, p.Do):
            return _action(step)
        if isinstance(step, p.Parallel | p.AnyOf):
            return self._set(view, step, place, path)
        if isinstance(step, p.LoopBase):
            inside = view.forgetting(step.steps)
            body = self.sequence(inside, step.steps, (*place, "steps"), "")
            return Node(
                "loop", _lines("Loop", *_named(step), *_iterations(view, step, place)), [body]
            )
        if isinstance(step, p.If):
            return self._if(view, step, place, path)
        if isinstance(step, p.Use):
            return self._use(view, step, place)
        if isinstance(step, p.Group):
            body = self.sequence(view, step.steps, (*place, "steps"), f"{path}/")
            own = (f"reserves {joined(step.reserve, 'and')}",) if step.reserve else ()
            aside = ("in the background",) if step.mode else ()
            lines = _lines("Sequence", *_named(step), *own, *aside)
            return Node("sequence", lines, body.below)
        return _immediate(step)

    def _set(self, view: Outlook, step: Any, place: Place, path: str) -> Node:
        members = getattr(step, step.KIND)
        below = [
            self.step(view, one, (*place, step.KIND, index), f"{path}/{one.id or index}")
            for index, one in enumerate(members)
        ]
        what = "the first success wins" if isinstance(step, p.AnyOf) else "all at the same time"
        return Node("set", _lines(f"Action set of {len(members)}: {what}", *_named(step)), below)

    def _if(self, view: Outlook, step: p.If, place: Place, path: str) -> Node:
        below = []
        for name, steps in (("then", step.then), ("else", step.else_)):
            if steps:
                body = self.sequence(view, steps, (*place, name), f"{path}/{name}/")
                body.edge = name
                below.append(body)
        return Node("branch", _lines("If", *_named(step), bare(step.if_)), below)

    def _use(self, view: Outlook, step: p.Use, place: Place) -> Node:
        other, below = view.used(step, place), []
        if other is not None:
            protocol = other.protocol
            below.append(self.sequence(other, protocol.steps, ("steps",), "", protocol.name))
            if protocol.on_resume:
                again = self.sequence(other, protocol.on_resume, ("on_resume",), "", "on_resume")
                again.edge = "on_resume"
                below.append(again)
            if protocol.finally_:
                last = self.sequence(other, protocol.finally_, ("finally",), "", "finally")
                last.edge = "finally"
                below.append(last)
        return Node("use", _lines("Use", *_named(step), step.use, _arguments(step.with_)), below)


def _retried(node: Node, said: int | p.Retry | None) -> Node:
    if said is None:
        return node
    if isinstance(said, int):
        return Node("retry", (f"Retry: {count_of(said, 'attempt')}",), [node])
    lines = [f"Retry: {count_of(said.attempts, 'attempt')}"]
    if said.wait not in (0, "0 s"):
        factor = f", then x {said.factor:g}" if said.factor != 1 else ""
        lines.append(f"{said.wait} apart{factor}")
    if said.on:
        lines.append(f"on {joined(said.on, 'or')}")
    return Node("retry", tuple(lines), [node])


def _guard(step: p.StepBase) -> tuple[str, ...]:
    """What the step guard does, if anything: `when`, a total timeout, `on_error`."""
    lines = []
    if step.when is not None:
        lines.append(f"only when {bare(step.when)}")
    if step.timeout is not None and not isinstance(step, p.Do):
        lines.append(f"within {bare(step.timeout)}")
    if step.on_error in ("continue", "pause"):
        lines.append(
            {"continue": "continues after a failure", "pause": "pauses after a failure"}[
                step.on_error
            ]
        )
    return _lines("Step guard", *lines) if lines else ()


def _iterations(view: Outlook, step: p.LoopBase, place: Place) -> tuple[str, ...]:
    if isinstance(step, p.Foreach):
        name, raw = next(iter(step.foreach.items()))
        items = view.items(step, place)
        each = f"for each {name} of {bare(raw) if items is None else items_text(items)}"
        if step.at_once is None:
            return (each,)
        order = " in the shortest order" if step.order == "shortest" else ""
        return (each, f"{bare(step.at_once)} at once{order}")
    if isinstance(step, p.Repeat):
        times = view.number(step.repeat, (*place, "repeat"))
        return (f"{bare(step.repeat) if times is None else f'{times:,}'} times",)
    assert isinstance(step, p.While)
    most = () if step.max is None else (f"{bare(step.max)} times at most",)
    return (f"while {bare(step.while_)}", *most)


def _action(step: p.Do) -> Node:
    aside = ("in the background",) if step.mode else ()
    timeout = (f"within {bare(step.timeout)}",) if step.timeout is not None else ()
    lines = _lines(step.do, *_named(step), _arguments(step.with_), *timeout, *aside)
    return Node("action", lines)


def _immediate(step: Any) -> Node:
    said: Any = getattr(step, step.KIND, "")
    kind: Kind = "person" if isinstance(step, p.Confirm | p.Ask) else "instant"
    text = _arguments(said) if isinstance(said, dict) else bare(said)
    if isinstance(step, p.Wait) and step.until is not None:
        text = f"until {bare(step.until)}"
    choices = (joined(step.choices, "or"),) if isinstance(step, p.Ask) else ()
    return Node(kind, _lines(step.KIND.capitalize(), *_named(step), text, *choices))


def _named(step: p.StepBase) -> tuple[str, ...]:
    """The id, and the name if it has one."""
    return tuple(text for text in (step.id, step.name) if text)


def _arguments(given: dict[str, Any]) -> str:
    return ", ".join(f"{name} = {bare(raw)}" for name, raw in given.items())


def _lines(*lines: str) -> tuple[str, ...]:
    """Each wrapped to two lines at most."""
    return tuple(part for line in lines for part in wrap(shortened(line, 2 * LINE), LINE))
