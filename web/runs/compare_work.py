"""Compare a run with a protocol to resume it with, in the worker: a whole journal is read."""

from pathlib import Path
from typing import Any

from ...engine.journal.history import read_history
from ...engine.journal.journal import JournalFault, read_records
from ...engine.run.folder import JOURNAL, FolderFault, newest_copies
from ...engine.runner.change import check_copy
from ...engine.runner.compare import compare
from ..library.text_check_work import found_problems, problems_refused
from ..local.refusal import Refusal

MOST = 200


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
    words = dict.fromkeys(one.words() for one in found.differences if one.was is not None)
    return {
        "can_resume": not found.undone, "agreeing": found.agreeing, "different": list(words)[:MOST],
        "in_the_way": [one.words() for one in found.undone][:MOST],
        "doubtful": [f"{after}: {one.words()}" for one, after in found.doubtful][:MOST],
        "reopened": len(found.reopened),
    }  # fmt: skip
