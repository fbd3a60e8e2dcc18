"""The result of a torture: kills, work done, promises kept and broken."""

from collections import Counter
from dataclasses import dataclass, field

from .accounts import Account
from .verdict import PROMISES, Breach

WIRE_WORDS = {
    "drop_request": "requests lost",
    "drop_reply": "replies lost",
    "duplicate": "messages delivered twice",
    "reorder": "messages out of order",
    "hang": "connections stalled",
    "cut": "connections cut",
}


@dataclass(slots=True)
class Report:
    """The sum over all runs."""

    runs: int = 0
    lives: int = 0
    torn: int = 0
    goals: int = 0
    once: int = 0
    points: int = 0
    probed: int = 0
    asked: int = 0
    dealt: Counter[str] = field(default_factory=Counter)
    wire: Counter[str] = field(default_factory=Counter)
    breaches: list[Breach] = field(default_factory=list)

    @property
    def kills(self) -> int:
        """Kills that happened, aborts included."""
        return self.dealt.total()

    def add(self, found: Account) -> None:
        """Count one run."""
        self.runs += 1
        self.lives += found.session
        self.torn += found.torn
        self.goals += len(found.sent)
        self.once += len(found.once)
        self.points += len(found.iterations)
        self.probed += len(found.probed)
        self.asked += sum(path.endswith("/unknown") for path in found.choices)

    def table(self) -> str:
        """The report as text."""
        blows = [[label, f"{count:,}"] for label, count in sorted(self.dealt.items())]
        blows += [[f"wire: {WIRE_WORDS[kind]}", f"{n:,}"] for kind, n in self.wire.items() if n]
        facts = [
            ["runs", f"{self.runs:,}"],
            ["engine sessions", f"{self.lives:,}"],
            ["loop points", f"{self.points:,}"],
            ["goals sent", f"{self.goals:,}"],
            ["`once` actions done", f"{self.once:,}"],
            ["unknown fates settled by a probe", f"{self.probed:,}"],
            ["unknown fates put to a person", f"{self.asked:,}"],
            ["incomplete records cut off", f"{self.torn:,}"],
        ]
        broken = Counter(breach.promise for breach in self.breaches)
        kept = [[words, f"{broken[name]:,} broken"] for name, words in PROMISES.items()]
        return "\n\n".join(
            [block("kills", blows), block("work done", facts), block("promise", kept)]
        )


def block(title: str, rows: list[list[str]]) -> str:
    """A title and its rows, in two columns."""
    width = max((len(row[0]) for row in rows), default=0)
    right = max((len(row[1]) for row in rows), default=0)
    lines = [f"  {name:<{width}}  {count:>{right}}" for name, count in rows]
    return "\n".join([title, *(lines or ["  none"])])
