"""One thing that went wrong and what followed; identical ones grouped."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from .formatting import pattern

EXAMPLES = 8
KINDS = 200
"""At most this many kinds are kept; the rest are counted together."""

OUTCOMES = (
    ("which succeeded", "succeeded when sent again"),
    ("which failed", "failed again"),
    ("it had happened", "turned out to have happened"),
    ("continued and succeeded", "did not prevent their iteration from succeeding"),
    ("a hole", "ended in a hole"),
    ("the run continued", "did not stop the run"),
    ("run was aborted", "were part of an abort"),
    ("the run ", "ended the run"),
)


@dataclass(slots=True)
class Incident:
    """A goal that failed, was cancelled, or whose outcome was unknown for a while.

    `doubt`: why it was unknown whether it had happened; `followed`: what was done, in order.
    """

    at: str
    path: str
    attempt: int
    label: str
    error: str
    message: str
    happened: str = ""
    failed: bool = True
    doubt: str = ""
    life: int = 1
    n: int = 0
    followed: list[str] = field(default_factory=list)

    def say(self, what: str) -> None:
        """Add one thing that followed, unless it is already listed."""
        if what not in self.followed:
            self.followed.append(what)

    def outcome(self) -> str:
        """The final outcome, in a few words: what a reader counts."""
        last = self.followed[-1] if self.followed else ""
        for mark, words in OUTCOMES:
            if mark in last:
                return words
        return "otherwise handled"

    def kind(self) -> tuple[str, ...]:
        """The key by which incidents are grouped: all but place, time and the numbers in the message."""
        return (
            self.label, self.error, self.happened, pattern(self.message), self.doubt,
            *self.followed,
        )  # fmt: skip


@dataclass(slots=True)
class Group:
    """Incidents of one kind: the first few of them, and how many there were."""

    first: Incident
    count: int = 0
    last_at: str = ""
    examples: list[Incident] = field(default_factory=list)

    def add(self, incident: Incident) -> None:
        """Count one more."""
        self.count += 1
        self.last_at = max(self.last_at, incident.at)
        if len(self.examples) < EXAMPLES:
            self.examples.append(incident)


@dataclass(slots=True)
class Groups:
    """All incidents, in memory that does not grow with their number."""

    by_kind: dict[tuple[str, ...], Group] = field(default_factory=dict)
    others: int = 0

    def add(self, incident: Incident) -> None:
        """Add an incident that has ended to its group."""
        kind = incident.kind()
        if kind not in self.by_kind and len(self.by_kind) >= KINDS:
            self.others += 1
            return
        self.by_kind.setdefault(kind, Group(incident)).add(incident)

    def outcomes(self) -> dict[str, int]:
        """Outcome -> how often, the most frequent first."""
        found: dict[str, int] = {}
        for group in self.by_kind.values():
            words = group.first.outcome()
            found[words] = found.get(words, 0) + group.count
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    def __iter__(self) -> Iterator[Group]:
        yield from sorted(self.by_kind.values(), key=lambda group: (group.first.at, group.first.n))

    def __len__(self) -> int:
        return self.others + sum(group.count for group in self.by_kind.values())
