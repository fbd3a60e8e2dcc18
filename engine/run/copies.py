"""The files that a protocol names, copied into the run's folder: other protocols, tables, functions,
and what is sent to devices.

`used.json` says what each name means there, so that resume needs nothing from outside.
"""

import json
from pathlib import Path

from ..language.own_functions import OwnFunction
from ..language.used_files import COPIES, USED
from ..survey.sent_files import sent_files
from ..survey.survey import Survey


class Copying:
    """Copies each file once, whatever names it is used by and however often."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.copies: dict[Path, str] = {}
        self.meaning: dict[str, dict[str, str]] = {}

    def protocol(self, name: str, survey: Survey) -> None:
        """Copy what the protocol of this name in the folder uses."""
        meaning = self.meaning.setdefault(name, {})
        for written, path in survey.tables.opened.items():
            meaning[written] = self.file(path)
        for written, path in sent_files(survey).items():
            meaning[written] = self.file(path)
        for function in survey.functions.values():
            if isinstance(function, OwnFunction):
                meaning[function.written] = self.file(function.path)
        for used in survey.used.values():
            meaning[used.step.use] = copy = self.file(used.path)
            self.protocol(copy, used.survey)
        if not meaning:
            del self.meaning[name]

    def file(self, path: Path) -> str:
        """The name of a file's copy in the folder, made when it is first needed."""
        key = path.resolve()
        if key not in self.copies:
            name = f"{COPIES}/{len(self.copies) + 1}-{path.name}"
            (self.folder / COPIES).mkdir(exist_ok=True)
            (self.folder / name).write_bytes(path.read_bytes())
            self.copies[key] = name
        return self.copies[key]


def keep_used(folder: Path, name: str, survey: Survey) -> None:
    """Copy everything that a protocol uses besides its own copy, which has this name."""
    copying = Copying(folder)
    copying.protocol(name, survey)
    if copying.meaning:
        text = json.dumps(copying.meaning, indent=1, ensure_ascii=False)
        (folder / USED).write_text(text + "\n", encoding="utf-8")
