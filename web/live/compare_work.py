"""A run held against the protocol with which it could go on, in the worker: a whole journal is read."""

from pathlib import Path
from typing import Any

from ...engine.commands.changed import newest_copies
from ...engine.commands.resume import check_copy
from ...engine.compare import compare
from ...engine.journal import JournalFault, read_records
from ...engine.run_folder import JOURNAL, FolderFault
from ..guard.refusal import Refusal
from ..shelf.look_work import found_problems, problems_refused

MOST = 200


def changes(asked: dict[str, Any]) -> dict[str, Any]:
    """The fields of `Changes` that the engine's comparison gives; raises Refusal."""
    folder = Path(asked["run"])
    changed = Path(asked["changed"]) if asked["changed"] is not None else None
    try:
        records = list(read_records(folder / JOURNAL))
        checked, _ = check_copy(newest_copies(folder, records), changed, asked["params"])
    except (JournalFault, FolderFault) as fault:
        raise Refusal(409, "UNREADABLE", str(fault)) from fault
    if not checked.ok:
        problems = found_problems(checked, Path(asked["folder"]))
        raise problems_refused(problems, "the changed protocol")
    found = compare(checked, folder.name, records)
    words = dict.fromkeys(one.words() for one in found.differences if one.was is not None)
    return {
        "can_resume": not found.undone, "agreeing": found.agreeing, "different": list(words)[:MOST],
        "in_the_way": [one.words() for one in found.undone][:MOST],
        "doubtful": [f"{after}: {one.words()}" for one, after in found.doubtful][:MOST],
        "reopened": len(found.reopened),
    }  # fmt: skip
