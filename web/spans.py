"""How long engines lived, how long nobody ran the run, how long it was held."""

from dataclasses import dataclass, field
from itertools import pairwise

from .words import seconds_between


@dataclass(slots=True)
class Life:
    """One engine's share of a run; `under_way` goals had no end in the journal when it ended."""

    number: int
    began: str
    ended: str
    labrun: str
    fate: str = ""
    reason: str = ""
    goals: int = 0
    under_way: int = 0
    torn: int = 0

    @property
    def seconds(self) -> float:
        """From its first record to its last."""
        return seconds_between(self.began, self.ended)


@dataclass(slots=True)
class Hold:
    """One pause: why or by whom, and until when."""

    began: str
    by: str
    ended: str = ""
    ended_by: str = ""


@dataclass(slots=True)
class Spans:
    """The lives of a run in order, and its pauses."""

    lives: list[Life] = field(default_factory=list)
    holds: list[Hold] = field(default_factory=list)

    @property
    def running_s(self) -> float:
        """The time in which an engine lived, pauses included."""
        return sum(life.seconds for life in self.lives)

    @property
    def paused_s(self) -> float:
        """The time for which a person or a step held the run."""
        return sum(seconds_between(hold.began, hold.ended) for hold in self.holds if hold.ended)

    @property
    def away_s(self) -> float:
        """The time between engines."""
        return sum(seconds_between(a.ended, b.began) for a, b in pairwise(self.lives))

    def pause(self, at: str, by: str) -> None:
        """The run is held."""
        self.holds.append(Hold(at, by))

    def go_on(self, at: str, by: str) -> None:
        """The hold is over: somebody said so, or the engine is gone."""
        if self.holds and not self.holds[-1].ended:
            self.holds[-1].ended, self.holds[-1].ended_by = at, by
