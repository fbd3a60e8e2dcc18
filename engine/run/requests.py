"""What nodes ask of the ticker: another tick, now or by some time, a pause, a new tree."""

from dataclasses import dataclass


@dataclass(slots=True)
class Requests:
    """`pause`: why, for a person. `take_up`: plant a new tree, which goes on from the journal."""

    pause: str = ""
    take_up: bool = False
    _again: bool = False
    _wake_at: float | None = None
    _look_at: float | None = None

    def again(self) -> None:
        """Tick once more before waiting: something changed that no event will report."""
        self._again = True

    def wake_at(self, when: float) -> None:
        """Tick at this time of the run's clock at the latest."""
        if self._wake_at is None or when < self._wake_at:
            self._wake_at = when

    def look_at(self, when: float) -> None:
        """Tick at this time of the event loop at the latest, also while the run is paused."""
        if self._look_at is None or when < self._look_at:
            self._look_at = when

    def take_round(self) -> tuple[bool, float | None, float | None]:
        """Whether another tick was requested, and by when, on either clock; all are reset."""
        asked = self._again, self._wake_at, self._look_at
        self._again, self._wake_at, self._look_at = False, None, None
        return asked
