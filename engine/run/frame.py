"""Where a step is: its path in the run, and the names that its expressions may use."""

from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping
from typing import Any
from urllib.parse import quote

from .reservations import Reservation


def segment(text: str) -> str:
    """A key as one part of a path: a slash in it separates nothing."""
    return quote(text, safe=",.:;=+-_ ()[]@")


class Results(Mapping[str, Any]):
    """`steps.ID` in expressions: this frame's results, then those around it; null if none."""

    def __init__(self, around: "Results | None" = None) -> None:
        self.own: dict[str, Any] = {}
        self.times: dict[str, Mapping[str, Any]] = {}
        self.around = around

    def known(self) -> dict[str, Any]:
        """The results that there are."""
        return {**(self.around.known() if self.around is not None else {}), **self.own}

    def times_of(self, step: str) -> Mapping[str, Any]:
        """When a step began and how long it took; nothing if it did not run, or nothing asks."""
        if step in self.times:
            return self.times[step]
        return self.around.times_of(step) if self.around is not None else {}

    def __getitem__(self, step: str) -> Any:
        if step in self.own:
            return self.own[step]
        return self.around[step] if self.around is not None else None

    def __contains__(self, step: object) -> bool:
        return True  # a step that did not run has the result null

    def __iter__(self) -> Iterator[str]:
        yield from self.own

    def __len__(self) -> int:
        return len(self.own)


class Frame:
    """One iteration of a loop, one phase, one fallback or one turn of a retried group.

    Frames of iterations and phases own results; the others share those of the frame around them.
    """

    __slots__ = (
        "around", "attempts", "joiner", "keys", "names", "outer_sets", "own", "owner", "parent", "path",
        "pending", "repeats", "reservation", "strand", "urgent",
    )  # fmt: skip

    def __init__(
        self, path: str, own: dict[str, Any], parent: "Frame | None", *, owns: bool, joins: bool
    ) -> None:
        self.path = path
        self.parent = parent
        self.own = own
        self.keys: str = parent.keys if parent is not None else ""
        self.around: tuple[tuple[Callable[[int], str], int], ...] = parent.around if parent else ()
        """The iterations in which it is, from the outermost: what names them, and their numbers."""
        self.names: ChainMap[str, Any] = ChainMap(own, *(parent.names.maps if parent else ()))
        self.owner: Frame = self if owns or parent is None else parent.owner
        self.joiner: Frame = self if joins or parent is None else parent.joiner
        self.urgent: bool = parent is not None and parent.urgent
        """What is done in it is done at once, also while the run is paused: a watch was right."""
        self.reservation: Reservation | None = parent.reservation if parent else None
        self.strand: str = parent.strand if parent is not None else ""
        """What of it runs beside other things: an iteration of several at once, a reservation."""
        self.attempts: dict[str, int] = {}
        self.pending: list[Any] = []
        self.repeats = False
        """Whether finished steps of this owner are done again, their device touched."""
        self.outer_sets: dict[str, Any] = {}

    @classmethod
    def phase(cls, name: str, names: dict[str, Any], around: "Frame | None" = None) -> "Frame":
        """The frame of a whole phase: `main`, `resume:1`, or `finally:1` with main's results."""
        results = Results(around.names["steps"] if around is not None else None)
        made = cls(name, {**names, "steps": results}, None, owns=True, joins=True)
        if around is not None:
            made.urgent, made.reservation, made.strand = (
                around.urgent, around.reservation, around.strand,
            )  # fmt: skip
        return made

    def iteration(self, path: str, key: str, names: dict[str, Any]) -> "Frame":
        """One iteration of a loop in this frame."""
        own = {**names, "steps": Results(self.names["steps"])}
        inner = Frame(path, own, self, owns=True, joins=True)
        inner.keys = f"{self.keys}/{key}" if self.keys else key
        return inner

    def another(self, path: str, names: dict[str, Any]) -> "Frame":
        """The frame of a used protocol: it sees nothing of what is around it."""
        inner = Frame(path, {**names, "steps": Results()}, None, owns=True, joins=True)
        inner.keys, inner.around, inner.urgent = self.keys, self.around, self.urgent
        inner.reservation, inner.strand = self.reservation, self.strand
        return inner

    def within(self, path: str, names: dict[str, Any] | None = None) -> "Frame":
        """A part of this frame with its own path: results go where they went before."""
        return Frame(path, names or {}, self, owns=False, joins=False)

    def apart(self, strand: str) -> "Frame":
        """The same place, for steps beside others: names and results of its own."""
        own = {"steps": Results(self.names["steps"])}
        inner = Frame(self.path, own, self, owns=True, joins=True)
        inner.strand = self.strand or strand
        return inner

    def joining(self) -> "Frame":
        """The same place, which waits for the background steps started in it: a group of steps."""
        return Frame(self.path, {}, self, owns=False, joins=True)

    def store(self, step: str, result: Any) -> None:
        """Keep a step's result for the expressions that follow."""
        self.owner.names["steps"].own[step] = result

    def store_times(self, step: str, times: Mapping[str, Any]) -> None:
        """Keep when a step began and how long it took."""
        self.owner.names["steps"].times[step] = times

    def assign(self, name: str, value: Any) -> None:
        """Give a `set` name its value: where it already has one, or else in this owner.

        Iterations that change a name from outside note it, since resume skips them later.
        """
        holder: Frame | None = self
        while holder is not None and name not in holder.own:
            holder = holder.parent
        target = holder or self.owner
        target.own[name] = value
        frame: Frame | None = self
        while frame is not None and frame is not target:
            if frame.owner is frame:
                frame.outer_sets[name] = value
            frame = frame.parent

    def next_attempt(self, path: str) -> int:
        """The number of the next attempt at a path; never the same twice in one frame."""
        self.attempts[path] = self.attempts.get(path, 0) + 1
        return self.attempts[path]


class Scope:
    """The current frame of a part of the tree; a loop rebinds it for each iteration."""

    __slots__ = ("frame",)

    def __init__(self, frame: Frame | None = None) -> None:
        self.frame: Frame = frame  # type: ignore[assignment]  # entered before it is read
