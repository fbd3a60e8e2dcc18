"""Follow a protocol as a run would if nothing failed, and note every point that it moves to."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import dist
from typing import Any

from ....schemas import protocol as p
from ....schemas.quantity import UnitError
from ...lab.bind import BoundRole
from ...language.grid import Grid
from ...language.shape import Place
from ..english import items_text
from ..forecast import UNKNOWN, Outlook
from .plane import AXES, Plane, in_mm, moves_in_plane, plane_of

MOST_POINTS = 20_000
MOST_VISITS = 200_000
"""At most this many steps are followed, whether they move or not."""
MOST_TURNS = 1000
"""For a `while` without its own limit."""


@dataclass(frozen=True, slots=True)
class Point:
    """A place that a device moves to; `joined` if it comes there from the previous point."""

    x_mm: float
    y_mm: float
    track: int
    joined: bool


@dataclass(slots=True)
class Path:
    """Where one device goes: its points in order, and what is not known."""

    plane: Plane
    points: list[Point] = field(default_factory=list)
    tracks: list[str] = field(default_factory=list)
    unknown: int = 0

    @property
    def outside(self) -> list[int]:
        """The numbers, from 0, of the points outside the area."""
        area = self.plane.area
        return [i for i, one in enumerate(self.points) if not area.holds(one.x_mm, one.y_mm)]

    @property
    def length_mm(self) -> float:
        """How far the device goes from point to point."""
        pairs = zip(self.points, self.points[1:], strict=False)
        return sum(dist((a.x_mm, a.y_mm), (b.x_mm, b.y_mm)) for a, b in pairs if b.joined)


class Full(Exception):
    """There are more points than are drawn."""


@dataclass(slots=True)
class Walk:
    """The paths of all devices, by name; `notes` state what was assumed."""

    most: int = MOST_POINTS
    paths: dict[str, Path] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    full: bool = False
    _at: dict[str, dict[str, float | None]] = field(default_factory=dict)
    _joined: dict[str, bool] = field(default_factory=dict)
    _tracks: dict[tuple[str, Place], int] = field(default_factory=dict)
    _visits: int = 0
    _moving: dict[Place, bool] = field(default_factory=dict)

    def follow(self, view: Outlook) -> "Walk":
        """Walk over the steps of a protocol, then over those of its `finally`."""
        for bound in view.roles.values():
            self._path(bound)
        try:
            self._sequence(view, view.protocol.steps, ("steps",), "steps", ())
            self._sequence(view, view.protocol.finally_, ("finally",), "finally", ("finally",))
        except Full:
            self.full = True
        return self

    def _sequence(
        self, view: Outlook, steps: Sequence[Any], place: Place, name: str, track: Place
    ) -> Outlook:
        """Steps in sequence; returns the names that are known after them."""
        self._visits += len(steps)
        if self._visits > MOST_VISITS:
            raise Full
        for index, step in enumerate(steps):
            here = (*place, index)
            if not self._skipped(view, step, here):
                self._step(view, step, here, name, track)
            view = view.after(step, here)
        return view

    def _skipped(self, view: Outlook, step: p.StepBase, place: Place) -> bool:
        if not self._moves(view, step, place):
            return True
        if step.when is None:
            return False
        truth = view.truth(step.when, (*place, "when"))
        if truth is None:
            self._note("Steps whose `when` is known only during the run are drawn.")
        return truth is False

    def _step(self, view: Outlook, step: Any, place: Place, name: str, track: Place) -> None:
        if isinstance(step, p.Do):
            self._do(view, step, place, name, track)
        elif isinstance(step, p.Foreach):
            self._foreach(view, step, place)
        elif isinstance(step, p.Repeat | p.While):
            self._iterations(view, step, place)
        elif isinstance(step, p.If):
            self._if(view, step, place, name, track)
        elif isinstance(step, p.Use):
            self._use(view, step, place)
        else:
            for key, steps in p.inner_lists(step):
                self._sequence(view, steps, (*place, key), name, track)

    # --- one method per kind

    def _foreach(self, view: Outlook, step: p.Foreach, place: Place) -> None:
        ((variable, _),) = step.foreach.items()
        items = view.items(step, place)
        inside = view.forgetting(step.steps)
        name = step.id or f"for each {variable}"
        if isinstance(items, Grid):
            name = f"{name}: {items_text(items)}"
        before = self._seen()
        for item in [UNKNOWN] if items is None else items:
            turn = inside.bound(**{variable: item})
            self._sequence(turn, step.steps, (*place, "steps"), name, (*view.within, *place))
        if items is None and self._seen() > before:
            self._note(
                f"{step.id or variable}: one turn is drawn; its items are known only during the run."
            )

    def _iterations(self, view: Outlook, step: p.Repeat | p.While, place: Place) -> None:
        """Turn by turn as long as it is known that there is another; at least the first."""
        before, turn, name = self._seen(), 0, step.id or step.KIND
        more = self._more(view, step, place, turn)
        while more or (more is None and turn == 0):
            track = (*view.within, *place)
            view = self._sequence(view, step.steps, (*place, "steps"), name, track)
            turn += 1
            if more is None:
                break
            more = self._more(view, step, place, turn)
        if more is None and self._seen() > before:
            turns = "turn is" if turn == 1 else f"{turn:,} turns are"
            self._note(
                f"{name}: the first {turns} drawn; whether there are more is known only during the run."
            )

    def _more(
        self, view: Outlook, step: p.Repeat | p.While, place: Place, turn: int
    ) -> bool | None:
        """Whether there is another turn; None if only the run can tell."""
        if isinstance(step, p.Repeat):
            turns = view.number(step.repeat, (*place, "repeat"))
            return None if turns is None else turn < turns
        most = None if step.max is None else view.number(step.max, (*place, "max"))
        if most is not None and turn >= most:
            return False
        if most is None and turn >= MOST_TURNS:
            return None
        return view.truth(step.while_, (*place, "while"))

    def _if(self, view: Outlook, step: p.If, place: Place, name: str, track: Place) -> None:
        truth = view.truth(step.if_, (*place, "if"))
        if truth is None and step.else_:
            self._note("Both branches of an `if` that is decided during the run are drawn.")
        if truth is not False:
            self._sequence(view, step.then, (*place, "then"), name, track)
        if truth is not True:
            self._sequence(view, step.else_ or [], (*place, "else"), name, track)

    def _use(self, view: Outlook, step: p.Use, place: Place) -> None:
        other = view.used(step, place)
        if other is not None:
            name = step.id or other.protocol.name
            for section, steps in other.lists:
                self._sequence(other, steps, (section,), name, other.within)

    # --- points

    def _do(self, view: Outlook, step: p.Do, place: Place, name: str, track: Place) -> None:
        role, _, action = step.do.partition(".")
        bound = view.roles[role]
        path = self._path(bound)
        assert path is not None
        at = self._at.setdefault(bound.device, dict.fromkeys(AXES))
        if not moves_in_plane(bound.contract, action):
            at.update(dict.fromkeys(AXES))  # homed, say: its position is now unknown
            self._joined[bound.device] = False
            return
        given = [axis for axis in AXES if axis in step.with_]
        for axis in given:
            unit = bound.contract.actions[action].param_schemas()[axis]["unit"]
            at[axis] = self._length(view, step.with_[axis], (*place, "with", axis), unit)
        x, y = at["x"], at["y"]
        if given and x is not None and y is not None:
            self._note_point(path, x, y, name, track)
        elif given:
            if path.unknown >= self.most:
                raise Full
            path.unknown += 1
            self._joined[bound.device] = False

    def _length(self, view: Outlook, raw: Any, place: Place, unit: str) -> float | None:
        value = view.value(raw, place)
        try:
            return None if value is UNKNOWN or value is None else in_mm(value, unit)
        except (UnitError, TypeError):
            return None  # of another dimension, which the checks have reported

    def _note_point(self, path: Path, x: float, y: float, name: str, track: Place) -> None:
        if sum(len(one.points) for one in self.paths.values()) >= self.most:
            raise Full
        device = path.plane.device
        if (device, track) not in self._tracks:
            self._tracks[device, track] = len(path.tracks)
            path.tracks.append(name)
        elif path.tracks[self._tracks[device, track]] != name:  # another grid, the next time
            path.tracks[self._tracks[device, track]] = name.partition(":")[0]
        joined = self._joined.get(device, False)
        path.points.append(Point(x, y, self._tracks[device, track], joined))
        self._joined[device] = True

    def _path(self, bound: BoundRole) -> Path | None:
        if bound.device not in self.paths:
            plane = plane_of(bound)
            if plane is None:
                return None
            self.paths[bound.device] = Path(plane)
        return self.paths[bound.device]

    def _moves(self, view: Outlook, step: p.StepBase, place: Place) -> bool:
        """True if a step, or one inside it, moves a device in a plane."""
        key = (*view.within, *place)
        if key not in self._moving:
            self._moving[key] = self._has_moves(view, step, place)
        return self._moving[key]

    def _has_moves(self, view: Outlook, step: p.StepBase, place: Place) -> bool:
        if isinstance(step, p.Do):
            if (found := view.survey.action(step)) is None:
                return False
            bound, action = found
            moving = action.danger == "motion" or "x" in step.with_
            return moving and self._path(bound) is not None
        if isinstance(step, p.Use):
            other = view.used(step, place)
            return other is not None and any(
                self._moves(other, one, (section, index))
                for section, steps in other.lists
                for index, one in enumerate(steps)
            )
        return any(
            self._moves(view, one, (*place, key, index))
            for key, steps in p.inner_lists(step)
            for index, one in enumerate(steps)
        )

    def _seen(self) -> int:
        """The points so far, with those that are not known."""
        return sum(len(path.points) + path.unknown for path in self.paths.values())

    def _note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)
