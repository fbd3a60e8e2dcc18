"""The steps of a protocol as rows, with their paths in journals."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from ...engine.check import Checked
from ...engine.journal.past import without_passes
from ...engine.language.shape import Place
from ...engine.views.english import shortened, upper_first
from ...engine.views.forecast import Outlook, outlook
from ...engine.views.words.act import action_sentence
from ...engine.views.words.loops import loop_words
from ...engine.views.words.speak import condition, spoken
from ...schemas import protocol as p
from ..library.pointer import pointer_text
from ..models.runs import OutlineNode

TURN = re.compile(r"([raf])(\d+)")
WATCH = re.compile(r"w(\d+)\.(?:\d+|look)")
LAST = re.compile(r"e\d*")
FOUND = 1000
"""So many paths and their steps are kept: a goal's end asks for that of its sending."""
PHASES = (("resume", "on_resume"), ("main", "steps"), ("finally", "finally"))


@dataclass(slots=True, eq=False)
class Step:
    """A node of the outline, found by its path.

    `frame` is the node of its frame, where the path of a retried group restarts. `back` has the
    `on_resume` of a used protocol.
    """

    told: OutlineNode
    frame: "Step | None"
    below: "dict[str, Step]" = field(default_factory=dict)
    alternatives: "list[dict[str, Step]]" = field(default_factory=list)
    watches: "dict[int, dict[str, Step]]" = field(default_factory=dict)
    last: "dict[str, Step]" = field(default_factory=dict)
    back: "Step | None" = None
    place: Place = ()
    view: Outlook | None = None
    step: Any = None

    @property
    def is_loop(self) -> bool:
        """True if a key follows it in a path."""
        return self.told.loop


@dataclass(frozen=True, slots=True)
class Found:
    """The target of a path; `loops` are the loops around it with their keys, outermost first."""

    step: Step
    loops: tuple[tuple[str, str], ...]

    @property
    def within(self) -> str:
        """The keys of the iterations around it, separated by slashes."""
        return "/".join(key for _, key in self.loops)

    @property
    def around(self) -> str:
        """Those without the key of the innermost loop."""
        return "/".join(key for _, key in self.loops[:-1])

    @property
    def innermost(self) -> tuple[str, str] | tuple[None, None]:
        """The innermost loop and its key."""
        return self.loops[-1] if self.loops else (None, None)


class Outline:
    """All steps of a protocol, and the lookup from a path to its step."""

    def __init__(self, checked: Checked) -> None:
        self.nodes: list[OutlineNode] = []
        self.phases: dict[str, dict[str, Step]] = {}
        self.steps: dict[str, Step] = {}
        self._source = checked.source
        self.find = lru_cache(FOUND)(self._find)
        """The step of a journal path; None if it is not in this protocol."""
        view = outlook(checked)
        for phase, section in PHASES:
            steps = {
                "steps": view.protocol.steps, "on_resume": view.protocol.on_resume,
                "finally": view.protocol.finally_,
            }[section]  # fmt: skip
            below = self._sequence(view, steps, (section,), phase, None, None)
            self.phases[phase] = below

    def _find(self, path: str) -> Found | None:
        first, *rest = without_passes(path).split("/")
        phase = first.partition(":")[0]
        below = self.phases.get(phase)
        if below is None:
            return None
        if phase == "resume" and rest[:1] == ["main"]:
            return self._resumed(rest[1:])
        return self._walk(rest, below)[0]

    def _resumed(self, parts: list[str]) -> Found | None:
        """A step of the `on_resume` of a used protocol: below the path of that use."""
        for count in reversed(range(1, len(parts))):
            use, length = self._walk(parts[:count], self.phases["main"])
            if use is None or length < count or (back := use.step.back) is None:
                continue
            found, _ = self._walk(parts[count:], back.below)
            if found is not None:
                return Found(found.step, (*use.loops, *found.loops))
        return None

    def _walk(self, rest: list[str], below: dict[str, Step]) -> tuple[Found | None, int]:
        """Where a path leads from here, and how many of its parts were understood."""
        here: Step | None = None
        loops: list[tuple[str, str]] = []
        top = below
        index = 0
        while index < len(rest):
            part = rest[index]
            if part in below:
                here = below[part]
                below, index = here.below, index + 1
                if here.is_loop and index < len(rest):
                    loops.append((here.told.path, rest[index]))
                    index += 1
                continue
            turn = TURN.fullmatch(part)
            if here is not None and turn is not None:
                index += 1
                if turn[1] == "r":
                    here = here.frame
                    below = top if here is None else here.below
                elif turn[1] == "f" and int(turn[2]) <= len(here.alternatives):
                    below = here.alternatives[int(turn[2]) - 1]
                continue
            watch = WATCH.fullmatch(part)
            if here is not None and watch is not None:
                below, index = here.watches.get(int(watch[1]), {}), index + 1
                continue
            if here is not None and LAST.fullmatch(part):
                below, index = here.last, index + 1
                continue
            break
        return (None if here is None else Found(here, tuple(loops))), index

    # --- from the protocol

    def _sequence(
        self, view: Outlook, steps: Sequence[Any], place: Place, path: str,
        parent: Step | None, frame: Step | None, edge: str = "",
    ) -> dict[str, Step]:  # fmt: skip
        found: dict[str, Step] = {}
        for before, step, here in view.along(steps, place):
            name = step.id or str(here[-1])
            found[name] = self._step(before, step, here, f"{path}/{name}", parent, frame, edge)
        return found

    def _step(
        self, view: Outlook, step: Any, place: Place, path: str,
        parent: Step | None, frame: Step | None, edge: str = "",
    ) -> Step:  # fmt: skip
        told = OutlineNode(
            path=path, parent=parent.told.path if parent is not None else None,
            depth=parent.told.depth + 1 if parent is not None else 0,
            kind=step.KIND, id=step.id, title=edge + _title(view, step, place),
            loop=isinstance(step, p.LoopBase), **_action(view, step),
        )  # fmt: skip
        if self._source is not None and not view.within:
            told.line = self._source.place(place)[0]
            told.pointer = pointer_text(list(place))
        made = Step(told, frame, place=place, view=view, step=step)
        self.nodes.append(told)
        self.steps[path] = made
        self._inside(view, step, place, path, made)
        for number, one in enumerate(step.fallback, 1):
            at, base = (*place, "fallback", number - 1), f"{path}/f{number}"
            mark = "otherwise: " if number == 1 else "if that fails too: "
            if isinstance(one, list):
                found = self._sequence(view, one, at, base, made, made, mark)
            else:
                name = one.id or "0"
                found = {name: self._step(view, one, at, f"{base}/{name}", made, made, mark)}
            made.alternatives.append(found)
        for then, keys in p.thens(step):
            at, base = (*place, *keys), f"{path}/w{keys[1] + 1}"
            steps = then if isinstance(then, list) else [then]
            found = {}
            for index, one in enumerate(steps):
                name, here = one.id or str(index), (*at, index) if isinstance(then, list) else at
                found[name] = self._step(view, one, here, f"{base}/{name}", made, made, "watch: ")
            made.watches[keys[1] + 1] = found
        return made

    def _inside(self, view: Outlook, step: Any, place: Place, path: str, made: Step) -> None:
        if isinstance(step, p.LoopBase):
            inside = view.forgetting(step.steps)
            at, inner = (*place, "steps"), f"{path}/*"
            made.below = self._sequence(inside, step.steps, at, inner, made, made)
        elif isinstance(step, p.If):
            for name, steps in (("then", step.then), ("else", step.else_ or [])):
                edge = "" if name == "then" else "otherwise: "
                at, inner = (*place, name), f"{path}/{name}"
                below = self._sequence(view, steps, at, inner, made, made.frame, edge)
                if below:
                    made.below[name] = _branch(made, name, below)
        elif isinstance(step, p.Use):
            self._use(view, step, place, path, made)
        elif isinstance(step, p.Group):
            at = (*place, "steps")
            made.below = self._sequence(view, step.steps, at, path, made, made.frame)
        elif isinstance(step, p.Parallel | p.AnyOf):
            for index, member in enumerate(getattr(step, step.KIND)):
                name, at = member.id or str(index), (*place, step.KIND, index)
                made.below[name] = self._step(view, member, at, f"{path}/{name}", made, made.frame)

    def _use(self, view: Outlook, step: p.Use, place: Place, path: str, made: Step) -> None:
        other = view.used(step, place)
        if other is None:
            return
        steps, last, back = other.protocol.steps, other.protocol.finally_, other.protocol.on_resume
        made.below = self._sequence(other, steps, ("steps",), path, made, made)
        made.last = self._sequence(other, last, ("finally",), f"{path}/e", made, made, "last: ")
        if back:
            made.back = Step(made.told, made.frame)
            made.back.below = self._sequence(
                other, back, ("on_resume",), f"resume/{path}", made, made.back, "after a crash: "
            )


def _branch(made: Step, name: str, below: dict[str, Step]) -> Step:
    """The part `then` or `else` of a path: it has no row."""
    return Step(made.told.model_copy(update={"loop": False}), made.frame, below)


def _title(view: Outlook, step: Any, place: Place) -> str:
    if step.name:
        return shortened(step.name, 120)
    if isinstance(step, p.Do):
        return upper_first(shortened(action_sentence(view, step, place), 160))
    if isinstance(step, p.LoopBase):
        return shortened(loop_words(view, step, place), 160)
    if isinstance(step, p.Parallel):
        return "At the same time"
    if isinstance(step, p.AnyOf):
        return "Whichever succeeds first"
    if isinstance(step, p.If):
        return f"If {shortened(condition(view, step.if_, (*place, 'if')), 100)}"
    if isinstance(step, p.Use):
        return f"The protocol {step.use}"
    if isinstance(step, p.Group):
        return upper_first(step.id.replace("_", " ")) if step.id else "In order"
    said = getattr(step, step.KIND, "")
    text = (
        ", ".join(said)
        if isinstance(said, dict)
        else shortened(spoken(view, said, (*place, step.KIND)), 120)
    )
    return f"{step.KIND.capitalize()}: {text}"


def _action(view: Outlook, step: Any) -> dict[str, Any]:
    if not isinstance(step, p.Do):
        return {}
    role, _, name = step.do.partition(".")
    found = view.survey.action(step)
    return {"role": role, "action": name, "danger": None if found is None else found[1].danger}


def ancestors(steps: dict[str, Step], path: str) -> Iterator[str]:
    """The paths of the steps around a step, the nearest first."""
    at = steps[path].told.parent if path in steps else None
    while at is not None:
        yield at
        at = steps[at].told.parent
