"""How long actions really took: measured in runs, kept across restarts, given as percentiles."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import quantiles

from ...system.files import write_whole

MOST_RUNS = 20
MOST_TIMES = 60
"""At most this many durations are kept of one action in one run, evenly spread over it."""


@dataclass(frozen=True, slots=True)
class Spread:
    """Seconds of one action; the 20th and 80th percentile, and from how many runs."""

    low: float
    typical: float
    high: float
    runs: int


class Timings:
    """Run -> `device.action` -> seconds; the newest twenty runs."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._runs: dict[str, dict[str, list[float]]] = {}
        self._known: dict[str, Spread] = {}
        try:
            told = json.loads(path.read_bytes())
            self._runs = {run: dict(times) for run, times in told.items()}
        except (OSError, ValueError, TypeError, AttributeError):
            self._runs = {}  # read again from the journals

    def learn(self, run: str, times: Mapping[str, Sequence[float]]) -> None:
        """Include a run that has ended."""
        thin = {label: _thinned(all_s) for label, all_s in times.items() if all_s}
        if not thin or run in self._runs:
            return
        self._runs[run] = thin
        for old in sorted(self._runs)[: max(0, len(self._runs) - MOST_RUNS)]:
            del self._runs[old]
        self._known.clear()
        write_whole(self._path, json.dumps(self._runs).encode())

    def spread(self, label: str) -> Spread | None:
        """How long an action takes; None if no run has it."""
        if label not in self._known:
            told = [times[label] for times in self._runs.values() if label in times]
            seconds = sorted(s for times in told for s in times)
            if not seconds:
                return None
            cuts = quantiles(seconds, n=10, method="inclusive") if len(seconds) > 1 else seconds * 9
            self._known[label] = Spread(cuts[1], cuts[4], cuts[7], len(told))
        return self._known[label]


def _thinned(seconds: Sequence[float]) -> list[float]:
    step = max(1, len(seconds) // MOST_TIMES)
    return [round(one, 4) for one in seconds[::step]]
