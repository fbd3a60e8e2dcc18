"""Prepare a release, in the worker: a copy of all that the run will use, and what a person reads of it."""

import shutil
from hashlib import sha256
from pathlib import Path
from typing import Any

from ...engine.check import Checked, check_file
from ...engine.commands.release import copied, record_of
from ..library.form import hazards_of
from ..library.text_check_work import found_problems, problems_refused
from ..library.views import words_of
from ..local.refusal import Refusal


def prepare(asked: dict[str, Any]) -> dict[str, Any]:
    """The record of a release that nobody has given yet, with the copy in words; raises Refusal."""
    file, runs = Path(asked["file"]), Path(asked["runs"])
    folder = copied(_sound(file, asked, file.parent), runs, asked["params"])
    try:
        copy = next(folder.glob("protocol.*"))
        # What is read is what was copied: a file may be changed while a person reads.
        checked = _sound(copy, asked, folder)
        record = record_of(folder, checked, file, asked["params"])
        if asked["revision"] not in (None, sha256(copy.read_bytes()).hexdigest()):
            raise Refusal(
                409, "CHANGED", f"{file.name} was saved since you looked at it",
                "review it, then release it",
            )  # fmt: skip
    except BaseException:  # raised again: nobody else would remove it
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return {
        "record": record.model_dump(mode="json"),
        "words": words_of(checked).model_dump(mode="json"),
        "hazards": [one.model_dump(mode="json") for one in hazards_of(checked)],
    }


def _sound(file: Path, asked: dict[str, Any], folder: Path) -> Checked:
    lab = Path(asked["lab"]) if asked["lab"] is not None else None
    checked = check_file(file, lab=lab, bind=asked["bind"], params=asked["params"])
    if not checked.ok:
        raise problems_refused(found_problems(checked, folder))
    return checked
