"""Histories by their seeds: each protocol is drawn, or given, and lived through under accidents."""

import logging
import random
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

from ..check import Checked
from ..torture.report import block
from .history import IN_MEMORY, History, Outcome, compare
from .protocols import random_protocol

ALIKE = 20
"""So many histories in a row have the same protocol."""
MOST = 6
TOLD = 100
LOG = logging.getLogger("labrun")


@dataclass(slots=True)
class Report:
    """The sum over all histories."""

    histories: int = 0
    sessions: int = 0
    deeds: int = 0
    virtual_s: float = 0.0
    real_s: float = 0.0
    accidents: Counter[str] = field(default_factory=Counter)
    broken: list[Outcome] = field(default_factory=list)

    def add(self, outcome: Outcome) -> None:
        """Count one history."""
        self.histories += 1
        self.sessions += outcome.sessions
        self.deeds += outcome.deeds
        self.virtual_s += outcome.lasted_s
        self.accidents.update(outcome.accidents)
        if outcome.breaches:
            self.broken.append(outcome)

    def table(self) -> str:
        """The report as text."""
        accidents = [[name, f"{count:,}"] for name, count in sorted(self.accidents.items())]
        facts = [
            ["histories", f"{self.histories:,}"],
            ["engine sessions", f"{self.sessions:,}"],
            ["`once` actions done", f"{self.deeds:,}"],
            ["simulated hours", f"{self.virtual_s / 3600:,.1f}"],
            ["minutes of a processor", f"{self.real_s / 60:,.1f}"],
            ["histories a minute", f"{60 * self.histories / max(self.real_s, 1e-9):,.0f}"],
            ["histories that broke the promise", f"{len(self.broken):,}"],
        ]
        return f"{block('accidents', accidents)}\n\n{block('histories', facts)}"


def simulate(
    seeds: range, given: Checked | None = None, say: Callable[[str], None] = lambda text: None
) -> Report:
    """Live through a history for each seed, and sum them up."""
    report, began = Report(), time.process_time()
    for outcome in histories(seeds, given):
        report.add(outcome)
        report.real_s = time.process_time() - began
        if report.histories % TOLD == 0:
            broken = len(report.broken)
            say(f"up to seed {outcome.seed:,}: {report.histories:,} histories, {broken} broken")
    return report


def histories(seeds: range, given: Checked | None = None) -> Iterator[Outcome]:
    """A history for each seed; the same seed, and the same protocol, is the same history."""
    level = LOG.level
    LOG.setLevel(logging.CRITICAL + 1)
    try:
        drawn, protocol, right = -1, given, {}
        for seed in seeds:
            if seed // ALIKE != drawn or protocol is None:
                drawn = seed // ALIKE
                protocol = given or _drawn(drawn)
                right = _undisturbed(protocol, drawn)
            yield _history(protocol, seed, right)
    finally:
        LOG.setLevel(level)


def _drawn(number: int) -> Checked:
    folder = Path(tempfile.mkdtemp(prefix="labrun-drawn-", dir=IN_MEMORY))
    try:
        return random_protocol(Random(f"protocol {number}"), folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _undisturbed(checked: Checked, number: int) -> dict[str, dict[str, Any]]:
    """By path of a `once` action: what was set whenever nothing disturbed the run."""
    found = []
    for attempt in range(3):
        random.seed(attempt)
        outcome = History(checked, number * 3 + attempt, accidents=0, ledgers=False).live()
        if outcome.breaches:
            raise RuntimeError(f"undisturbed: {'; '.join(outcome.breaches)}")
        found.append(outcome.facts)
    first, *others = found
    return {
        path: {k: v for k, v in facts.items() if all(o[path].get(k) == v for o in others)}
        for path, facts in first.items()
        if path.startswith("main/")
    }


def _history(checked: Checked, seed: int, right: dict[str, dict[str, Any]]) -> Outcome:
    random.seed(seed)  # the client's pauses between attempts
    drawn = Random(f"history {seed}")
    history = History(
        checked,
        drawn.getrandbits(40),
        accidents=drawn.randint(1, MOST),
        ledgers=drawn.random() < 0.5,
    )
    outcome = history.live()
    outcome.seed = seed
    if not any("had not succeeded" in breach or "stood" in breach for breach in outcome.breaches):
        compare(outcome, right)
    return outcome
