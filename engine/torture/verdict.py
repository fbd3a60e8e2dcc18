"""The promise, line by line, compared with what happened in one tortured run."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

from ...schemas.contract import RESERVED_ERRORS
from .accounts import Account, Deed

PROMISES = {
    "end": "every run ends as it does undisturbed",
    "twice": "no `once` action was done twice",
    "lost": "no point was lost, and none has two rows",
    "announced": "nothing was done that the journal had not announced",
    "known": "every unknown fate was declared and settled",
    "place": "every `once` action found the bench as it should be",
    "files": "every file is there and matches its hash",
    "safe": "every device was left in its safe state",
}


@dataclass(frozen=True, slots=True)
class Breach:
    """One promise that was not kept: where, and how."""

    promise: str
    run: str
    text: str


@dataclass(slots=True)
class Measure:
    """What an undisturbed run of the same protocol is like."""

    fate: str
    iterations: dict[str, str]
    facts: dict[str, dict[str, Any]]
    safe: set[str]
    lasts_s: float
    writes: int


def judge(found: Account, right: Measure) -> Iterator[Breach]:
    """Every breach of the promise in one run."""
    run = found.folder.name
    for promise, check in CHECKS.items():
        for text in check(found, right):
            yield Breach(promise, run, text)


def _end(found: Account, right: Measure) -> Iterator[str]:
    fate = found.finished.fate if found.finished else "interrupted"
    if fate != right.fate:
        reason = found.finished.reason if found.finished else "its journal has no end"
        yield f"it {fate}, undisturbed it {right.fate}: {reason}"


def _twice(found: Account, right: Measure) -> Iterator[str]:
    by_path: dict[str, list[Deed]] = defaultdict(list)
    for deed in found.once:
        by_path[deed.path].append(deed)
    for path, deeds in by_path.items():
        for earlier in deeds[:-1]:
            if not _may_repeat(found, earlier):
                yield f"{deeds[0].device} did {deeds[0].what} {len(deeds)} times for {path}"
                break


def _may_repeat(found: Account, deed: Deed) -> bool:
    """The device had reported a failure, or a person chose to repeat it."""
    ended = found.ended.get(deed.goal)
    error = ended.error if ended is not None else None
    own = deed.goal.partition("/")[2]
    said = error is not None and error.name not in RESERVED_ERRORS
    return said or found.choices.get(f"{own}/unknown") == "repeat"


def _lost(found: Account, right: Measure) -> Iterator[str]:
    done = {deed.path for deed in found.once}
    for path in right.facts:
        if path not in done and not path.startswith(("finally:", "resume:")):
            yield f"{path} was never done"
    for name, fate in right.iterations.items():
        ends = found.iterations.get(name, [])
        if len(ends) != 1:
            yield f"the point {name} ended {len(ends)} times"
        elif ends[0].fate != fate:
            yield f"the point {name} {ends[0].fate}, undisturbed it {fate}: {ends[0].message}"
        elif ends[0].row is not None and (
            empty := [k for k, v in ends[0].row.items() if v is None]
        ):
            yield f"the row of {name} has no {', '.join(empty)}"


def _announced(found: Account, right: Measure) -> Iterator[str]:
    for deed in found.deeds:
        if deed.goal not in found.sent:
            yield f"{deed.device} did {deed.what} for {deed.goal}, which is not in the journal"


def _known(found: Account, right: Measure) -> Iterator[str]:
    for goal, sent in found.sent.items():
        ended = found.ended.get(goal)
        error = ended.error if ended is not None else None
        unknown = ended is None or (error is not None and error.happened == "unknown")
        if sent.effect == "once" and unknown and not found.was_asked(goal):
            yield f"the fate of {goal} was neither known nor asked about"


def _place(found: Account, right: Measure) -> Iterator[str]:
    for deed in found.once:
        wanted = right.facts.get(deed.path, {})
        wrong = [k for k, v in wanted.items() if deed.facts.get(k) != v]
        if wrong:
            told = ", ".join(f"{k} {deed.facts.get(k)} instead of {wanted[k]}" for k in wrong)
            yield f"{deed.what} of {deed.device} for {deed.path}: {told}"


def _files(found: Account, right: Measure) -> Iterator[str]:
    newest = {
        path: digest for ended in found.ended.values() for path, digest in ended.files.items()
    }
    for path, digest in newest.items():
        try:
            data = (found.folder / path).read_bytes()
        except OSError as fault:
            yield f"{path}: {fault.strerror}"
            continue
        if sha256(data).hexdigest() != digest:
            yield f"{path} does not match its hash in the journal"


def _safe(found: Account, right: Measure) -> Iterator[str]:
    for device in sorted(right.safe):
        if not found.safe.get(device):
            yield f"{device} did not confirm its safe state"


CHECKS = {
    "end": _end, "twice": _twice, "lost": _lost, "announced": _announced, "known": _known,
    "place": _place, "files": _files, "safe": _safe,
}  # fmt: skip
"""In the order of PROMISES."""
