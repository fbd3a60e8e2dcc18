"""Two accounts of one run: that of its journal, and that of the devices' own logs."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from ...schemas import journal as j
from ..journal.course import Course, split_goal_id
from ..journal.journal import read_records

PASSING = ("n", "at", "goal", "elapsed_s", "shot")
"""Facts of a deed that show when it was done, not how."""


@dataclass(frozen=True, slots=True)
class Deed:
    """One thing that a simulated device really did, from the log that no engine can write to."""

    device: str
    what: str
    goal: str
    facts: dict[str, Any]

    @property
    def path(self) -> str:
        """The protocol's action that it was done for, whatever the attempt."""
        return split_goal_id(self.goal)[0]


@dataclass(slots=True)
class Account(Course):
    """Everything that is known about a run."""

    folder: Path = Path()
    deeds: list[Deed] = field(default_factory=list)
    sent: dict[str, j.GoalSent] = field(default_factory=dict)
    ended: dict[str, j.GoalEnded] = field(default_factory=dict)
    iterations: dict[str, list[j.IterationEnded]] = field(default_factory=dict)
    safe: dict[str, bool] = field(default_factory=dict)
    choices: dict[str, str] = field(default_factory=dict)
    probed: set[str] = field(default_factory=set)
    torn: int = 0

    @property
    def once(self) -> list[Deed]:
        """Deeds of actions that must not be done twice."""
        return [d for d in self.deeds if d.goal in self.sent and self.sent[d.goal].effect == "once"]

    @property
    def succeeded(self) -> bool:
        """True if the journal ends with the run's success."""
        return self.finished is not None and self.finished.fate == "succeeded"

    def was_asked(self, goal: str) -> bool:
        """True if the device or a person was asked about the fate of this goal."""
        own = goal.partition("/")[2]
        return goal in self.probed or f"{own}/unknown" in self.choices

    @property
    def lasts_s(self) -> float:
        """From its first record to its last."""
        assert self.started is not None
        began, last = self.started.at, self.last_at
        return (datetime.fromisoformat(last) - datetime.fromisoformat(began)).seconds + 1


def account(folder: Path, world: Path) -> Account:
    """Read journal and logs of one run; raises JournalFault if the chain is broken."""
    known = Account(folder=folder, deeds=list(_deeds(world / "truth", folder.name)))
    for record in read_records(folder / "journal.jsonl"):
        _note(known, record)
        known.take(record)
    return known


def _note(known: Account, record: j.JournalRecord) -> None:
    match record:
        case j.GoalSent():
            known.sent[record.id] = record
            path, _ = split_goal_id(record.id)
            if path.endswith("/probe"):
                known.probed.add(f"{record.id.partition('/')[0]}/{path.removesuffix('/probe')}")
        case j.GoalEnded():
            known.ended[record.id] = record
        case j.IterationEnded():
            known.iterations.setdefault(f"{record.loop}/{record.key}", []).append(record)
        case j.Answered():
            known.choices[record.path] = record.choice
        case j.SafeState():
            known.safe[record.device] = record.confirmed
        case j.Resumed():
            known.torn += bool(record.torn)
        case _:
            return


def _deeds(truth: Path, run: str) -> Iterator[Deed]:
    for path in sorted(truth.glob("*.jsonl")):
        for line in path.read_bytes().splitlines(keepends=True):
            told = json.loads(line) if line.endswith(b"\n") else {}
            if str(told.get("goal", "")).startswith(f"{run}/"):
                facts = {k: v for k, v in told.items() if k not in (*PASSING, "what")}
                yield Deed(path.stem, told["what"], told["goal"], facts)


def steady_facts(one: Account, other: Account) -> dict[str, dict[str, Any]]:
    """By path: what was the same in two undisturbed runs, and so must be in every other."""
    first = {deed.path: deed.facts for deed in one.once}
    return {
        deed.path: {k: v for k, v in deed.facts.items() if first[deed.path].get(k) == v}
        for deed in other.once
        if deed.path in first
    }
