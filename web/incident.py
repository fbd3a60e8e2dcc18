"""One thing that went wrong, what followed, and many that are alike put together."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from .words import pattern

EXAMPLES = 8
KINDS = 200
"""More kinds than that are no kinds: the rest is counted together."""

OUTCOMES = (
    ("which succeeded", "succeeded when sent again"),
    ("which failed", "failed again"),
    ("it had happened", "turned out to have happened"),
    ("went on and succeeded", "did not keep their iteration from succeeding"),
    ("a hole", "ended in a hole"),
    ("the run went on", "did not keep the run from going on"),
    ("run was aborted", "were part of an abort"),
    ("the run ", "ended the run"),
)


@dataclass(slots=True)
class Incident:
    """A goal that failed, was cancelled, or whose fate was not known for a while.

    `doubt` says why nobody knew whether it had happened; `followed` what was done, in order.
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
        """One more thing that followed, said once."""
        if what not in self.followed:
            self.followed.append(what)

    def outcome(self) -> str:
        """How it came out in the end, in a few words: what a reader counts."""
        last = self.followed[-1] if self.followed else ""
        for mark, words in OUTCOMES:
            if mark in last:
                return words
        return "otherwise handled"

    def kind(self) -> tuple[str, ...]:
        """What makes two incidents alike: all but where, when and the numbers in the message."""
        return (
            self.label, self.error, self.happened, pattern(self.message), self.doubt,
            *self.followed,
        )  # fmt: skip


@dataclass(slots=True)
class Group:
    """Incidents that are alike: the first few of them, and how many there were."""

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
    """All incidents, in room that does not grow with their number."""

    by_kind: dict[tuple[str, ...], Group] = field(default_factory=dict)
    others: int = 0

    def add(self, incident: Incident) -> None:
        """Put an incident that is over to those like it."""
        kind = incident.kind()
        if kind not in self.by_kind and len(self.by_kind) >= KINDS:
            self.others += 1
            return
        self.by_kind.setdefault(kind, Group(incident)).add(incident)

    def outcomes(self) -> dict[str, int]:
        """How it came out -> how often, the most frequent first."""
        found: dict[str, int] = {}
        for group in self.by_kind.values():
            words = group.first.outcome()
            found[words] = found.get(words, 0) + group.count
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    def __iter__(self) -> Iterator[Group]:
        yield from sorted(self.by_kind.values(), key=lambda group: (group.first.at, group.first.n))

    def __len__(self) -> int:
        return self.others + sum(group.count for group in self.by_kind.values())
