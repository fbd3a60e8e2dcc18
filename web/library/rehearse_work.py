"""A rehearsal in the worker: a text run on a virtual clock."""

from pathlib import Path
from typing import Any


def rehearse(asked: dict[str, Any]) -> dict[str, Any]:
    """The fields of `Rehearsed`; raises WrongUsage or NoRehearsal with a sentence."""
    from ...engine.check import check_text
    from ...engine.commands.rehearse import ordered
    from ...engine.rehearse.rehearse import NoRehearsal, Rehearsal
    from ...engine.rehearse.table import lines

    lab = Path(asked["lab"]) if asked["lab"] else None
    checked = check_text(
        asked["text"], asked["name"], lab=lab, bind=asked["bind"], params=asked["params"],
        needed=True,
    )  # fmt: skip
    if not checked.ok:
        raise NoRehearsal("the protocol has errors")
    rehearsal = Rehearsal(checked, ordered(asked["fail"], checked), asked["seed"])
    totals = rehearsal.play()
    return {
        "fate": totals.fate, "reason": totals.reason, "lasts_s": totals.lasts_s,
        "lines": list(lines(totals, rehearsal.real_s)), "gantt": totals.gantt,
    }  # fmt: skip
