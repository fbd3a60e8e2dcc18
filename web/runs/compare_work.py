"""Compare a run with a protocol to resume it with, in the worker: a whole journal is read."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ...engine.journal.history import read_history
from ...engine.journal.journal import JournalFault, read_records
from ...engine.run.folder import JOURNAL, FolderFault, newest_copies
from ...engine.runner.change import check_copy
from ...engine.runner.compare import Difference, compare
from ..library.text_check_work import found_problems, problems_refused
from ..local.refusal import Refusal
from .outline import Outline

MOST = 200
PLACES_SHOWN = 3


def changes(asked: dict[str, Any]) -> dict[str, Any]:
    """The fields of `Changes` from the engine's comparison; raises Refusal."""
    folder = Path(asked["run"])
    changed = Path(asked["changed"]) if asked["changed"] is not None else None
    try:
        records = list(read_records(folder / JOURNAL))
        checked, _ = check_copy(
            newest_copies(folder, read_history(records)), changed, asked["params"]
        )
    except (JournalFault, FolderFault) as fault:
        raise Refusal(409, "UNREADABLE", str(fault)) from fault
    if not checked.ok:
        problems = found_problems(checked, Path(asked["folder"]))
        raise problems_refused(problems, "the changed protocol")
    found = compare(checked, records)
    outline = Outline(checked)
    words = dict.fromkeys(one.words() for one in found.differences if one.was is not None)
    return {
        "can_resume": not found.undone, "agreeing": found.agreeing, "different": list(words)[:MOST],
        "in_the_way": grouped(outline, ((_words(outline, one), one.path) for one in found.undone)),
        "doubtful": grouped(
            outline,
            ((f"{one.words()}, then {_title(outline, path)}", path) for one, path in found.doubtful),
        ),
        "reopened": len(found.reopened),
    }  # fmt: skip


def grouped(outline: Outline, found: Iterable[tuple[str, str]]) -> list[str]:
    """Words and the path they are of: each once, with the iterations it is true of."""
    places: dict[str, list[str]] = {}
    for words, path in found:
        step = outline.find(path)
        places.setdefault(words, []).extend(
            [step.within] if step is not None and step.loops else []
        )
    return [f"{words}{_at(keys)}" for words, keys in places.items()][:MOST]


def _at(keys: list[str]) -> str:
    more = f" and {len(keys) - PLACES_SHOWN:,} more" if len(keys) > PLACES_SHOWN else ""
    return f" (at {' · '.join(keys[:PLACES_SHOWN])}{more})" if keys else ""


def _words(outline: Outline, one: Difference) -> str:
    """Of a step that would be done again elsewhere, the label is that path."""
    return one.words().replace(one.label, _title(outline, one.label))


def _title(outline: Outline, path: str) -> str:
    found = outline.find(path)
    return path if found is None else f"“{found.step.told.title}”"
