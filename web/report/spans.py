"""How long engines ran, how long none did, how long the run was paused."""

from dataclasses import dataclass, field
from itertools import pairwise

from .formatting import local_time, seconds_between


@dataclass(slots=True)
class EngineSpan:
    """One engine session of a run; `under_way` goals had no end in the journal when it ended.

    `set_back_s`: by how much the computer's clock was set back in it.
    """

    number: int
    began: str
    ended: str
    labrun: str
    fate: str = ""
    reason: str = ""
    goals: int = 0
    under_way: int = 0
    torn: int = 0
    set_back_s: float = 0.0

    @property
    def seconds(self) -> float:
        """From its first record to its last."""
        shown = (local_time(self.ended) - local_time(self.began)).total_seconds()
        return max(0.0, shown + self.set_back_s)

    def goes_on(self, at: str) -> None:
        """Its newest record was written then."""
        if at and at < self.ended:
            self.set_back_s += seconds_between(at, self.ended)
        self.ended = at


@dataclass(slots=True)
class Hold:
    """One pause: by whom or what, and until when."""

    began: str
    by: str
    ended: str = ""
    ended_by: str = ""


@dataclass(slots=True)
class Spans:
    """The engine sessions of a run in order, and its pauses; `earlier_s`: how long all but the last ran."""

    lives: list[EngineSpan] = field(default_factory=list)
    holds: list[Hold] = field(default_factory=list)
    earlier_s: float = 0.0

    @property
    def running_s(self) -> float:
        """The time with an engine running, pauses included."""
        return sum(life.seconds for life in self.lives)

    @property
    def paused_s(self) -> float:
        """The time for which a person or a step paused the run."""
        return sum(seconds_between(hold.began, hold.ended) for hold in self.holds if hold.ended)

    @property
    def away_s(self) -> float:
        """The time between engine sessions."""
        return sum(seconds_between(a.ended, b.began) for a, b in pairwise(self.lives))

    @property
    def set_back_s(self) -> float:
        """By how much the computer's clock was set back from the first session to the last."""
        between = sum(seconds_between(b.began, a.ended) for a, b in pairwise(self.lives))
        return between + sum(life.set_back_s for life in self.lives)

    def pause(self, at: str, by: str) -> None:
        """A pause begins."""
        self.holds.append(Hold(at, by))

    def go_on(self, at: str, by: str) -> None:
        """The pause ends: somebody resumed the run, or the engine is gone."""
        if self.holds and not self.holds[-1].ended:
            self.holds[-1].ended, self.holds[-1].ended_by = at, by
