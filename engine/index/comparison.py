"""Two or more runs beside each other: what differs between them, and what each came to."""

import difflib
import html
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from statistics import median
from typing import Any, TypeVar

from ...schemas.journal import GoalEnded, GoalSent
from ..journal.journal import JournalFault, Records
from ..run.folder import JOURNAL, FolderFault, protocol_file
from .entry import Entry, entry_of

T = TypeVar("T")
MOST = 8
MOST_LINES = 2000
WIDEST = 28
"""Characters of a column."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """Every list has one item for each run, in the order of `runs`; empty or None where it has none.

    `params`: those that differ; `same`: how many do not. `lines`: a unified diff of the first
    run's protocol with each other one's, empty for the first. `seconds`: the median of an action,
    by `DEVICE.ACTION`; `failures`: how often it ended so, by `DEVICE.ACTION ERROR`.
    """

    runs: list[Entry]
    params: dict[str, list[str]]
    same: int
    lines: list[list[str]]
    values: dict[str, list[float | None]]
    units: dict[str, str]
    took_s: list[float | None]
    seconds: dict[str, list[float | None]]
    failures: dict[str, list[int]]

    def __str__(self) -> str:
        """As lines of text, a column for each run."""
        return "\n".join(_lines_of(self))

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


@dataclass(slots=True)
class _Work:
    """What its journal says of one run's actions."""

    seconds: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    failures: dict[str, int] = field(default_factory=lambda: defaultdict(int))


def compare_runs(folders: list[Path]) -> Comparison:
    """Compare runs by their folders; what cannot be read of one is left empty."""
    entries = [entry_of(folder) for folder in folders]
    work = [_work(folder) for folder in folders]
    params = _beside([entry.param_texts for entry in entries], "")
    differing = {name: texts for name, texts in params.items() if len(set(texts)) > 1}
    numbers = [entry.numbers for entry in entries]
    texts = [_text(folder) for folder in folders]
    medians = [{name: median(all) for name, all in one.seconds.items()} for one in work]
    return Comparison(
        runs=entries, params=differing, same=len(params) - len(differing),
        lines=[[], *(_diff(texts[0], text) for text in texts[1:])],
        values=_beside([{name: told[0] for name, told in one.items()} for one in numbers], None),
        units={name: told[1] for one in numbers for name, told in one.items() if told[1]},
        took_s=[_took(entry) for entry in entries],
        seconds=_beside(medians, None), failures=_beside([one.failures for one in work], 0),
    )  # fmt: skip


def _beside(each: Sequence[Mapping[str, T]], missing: T) -> dict[str, list[T]]:
    names = dict.fromkeys(name for one in each for name in one)
    return {name: [one.get(name, missing) for one in each] for name in names}


def _took(entry: Entry) -> float | None:
    if not (entry.began and entry.ended):
        return None
    return (
        datetime.fromisoformat(entry.ended) - datetime.fromisoformat(entry.began)
    ).total_seconds()


def _text(folder: Path) -> list[str]:
    try:
        return protocol_file(folder).read_text(encoding="utf-8", errors="replace").splitlines()
    except (OSError, FolderFault):
        return []


def _diff(first: list[str], other: list[str]) -> list[str]:
    found = difflib.unified_diff(first, other, lineterm="", n=2)
    return [line for line in found if not line.startswith(("---", "+++"))][:MOST_LINES]


def _work(folder: Path) -> _Work:
    made, sent = _Work(), dict[str, GoalSent]()
    try:
        for record in Records(folder / JOURNAL, "goal", "ended"):
            if isinstance(record, GoalSent):
                sent[record.id] = record
            elif isinstance(record, GoalEnded) and (goal := sent.pop(record.id, None)) is not None:
                _take(made, goal, record)
    except JournalFault:
        return made
    return made


def _take(made: _Work, goal: GoalSent, end: GoalEnded) -> None:
    if end.state == "SUCCEEDED":
        took = datetime.fromisoformat(end.at) - datetime.fromisoformat(goal.at)
        made.seconds[goal.label].append(took.total_seconds())
    elif end.error is not None:
        made.failures[f"{goal.label} {end.error.name}"] += 1


def _lines_of(made: Comparison) -> list[str]:
    told = [_row("", [entry.run[-WIDEST:] for entry in made.runs])]
    told.append(_row("ended", [entry.word for entry in made.runs]))
    told.append(_row("points", [entry.points.words(entry.holes) for entry in made.runs]))
    told.append(_row("took", [_seconds(one) for one in made.took_s]))
    told += _part(f"parameters ({made.same} alike)", made.params, str)
    told += _part("values", made.values, lambda one: "" if one is None else f"{one:.6g}")
    told += _part("failures", made.failures, str)
    told += _part("median time", made.seconds, _seconds)
    for entry, lines in zip(made.runs[1:], made.lines[1:], strict=True):
        if lines:
            told += ["", f"protocol of {entry.run}, compared with the first:", *lines]
    if not any(made.lines):
        told += ["", "the same protocol, line by line"]
    return told


def _part(title: str, rows: dict[str, list[Any]], text: Any) -> list[str]:
    if not rows:
        return []
    return ["", title, *(_row(name, [text(one) for one in each]) for name, each in rows.items())]


def _row(name: str, cells: list[str]) -> str:
    return f"  {name:<26} {'  '.join(f'{cell:<{WIDEST}}' for cell in cells)}".rstrip()


def _seconds(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:.3g} s"
