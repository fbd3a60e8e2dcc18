"""One run in the index: what is shown of it in a list, and by what it is found."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from ...schemas.journal import Points, Started, ended_as
from ...schemas.quantity import is_number
from ...schemas.summary import Summary
from ..journal.encode import QUANTITY_KEY
from ..journal.journal import JournalFault, read_records
from ..run.came_to import SAMPLE, brief, value_text
from ..run.folder import ASKED, JOURNAL, is_live
from ..run.labels import read_labels, read_launch, read_object
from ..run.summary import kept_summary, summary_of


class Entry(NamedTuple):
    """A row of the index. Lists are lines of text; `params` and `values` are JSON as in a summary.

    Times are UTC as in the journal. `plan` and `left` are None where a loop's length is unknown.
    """

    run: str
    protocol: str = ""
    file: str = ""
    fate: str = ""
    word: str = ""
    reason: str = ""
    began: str = ""
    ended: str = ""
    person: str = ""
    samples: str = ""
    tags: str = ""
    note: str = ""
    devices: str = ""
    holes: int = 0
    resumes: int = 0
    plan: int | None = None
    measured: int = 0
    failed: int = 0
    left: int | None = None
    params: str = "{}"
    values: str = "{}"

    @property
    def points(self) -> Points:
        """The run in four numbers."""
        return Points(plan=self.plan, measured=self.measured, failed=self.failed, left=self.left)

    @property
    def param_texts(self) -> dict[str, str]:
        """Its parameters as people write them."""
        return {name: value_text(value) for name, value in json.loads(self.params).items()}

    @property
    def numbers(self) -> dict[str, tuple[float, str]]:
        """Outputs and means of columns: name -> number and unit."""
        return {name: (number, unit) for name, (number, unit) in json.loads(self.values).items()}

    def number(self, name: str) -> tuple[float, str] | None:
        """Of that name with its unit: what it came to, or a parameter; None for none."""
        if (told := self.numbers.get(name)) is not None:
            return told
        param = json.loads(self.params).get(name)
        number, unit = (
            param.get(QUANTITY_KEY, (None, "")) if isinstance(param, dict) else (param, "")
        )
        return (float(number), unit) if is_number(number) else None

    def words(self) -> str:
        """All its text, in small letters: what a search for a word looks through."""
        told: Iterable[str] = (
            self.run, self.protocol, self.file, self.word, self.reason, self.began, self.person,
            self.samples, self.tags, self.note, self.devices,
            *(f"{name}={text}" for name, text in self.param_texts.items()),
        )  # fmt: skip
        return "\n".join(told).lower()


COLUMNS = Entry._fields


def entry_of(folder: Path) -> Entry:
    """The entry of a run, made from what its folder says."""
    labels, launch = read_labels(folder), read_launch(folder)
    notes = (str(launch.get("note", "")), labels.note)
    said: dict[str, Any] = {
        "run": folder.name, "file": str(read_object(folder / ASKED).get("file", "")),
        "person": str(launch.get("operator", "")), "tags": "\n".join(labels.tags),
        "note": "\n".join(note for note in notes if note),
    }  # fmt: skip
    kept = kept_summary(folder)
    try:
        if kept is None and is_live(folder):
            return _of_live(folder, said, labels.sample)
        return _of_summary(kept or summary_of(folder), said, labels.sample)
    except (JournalFault, OSError, ValueError) as fault:
        return Entry(**said, fate="unreadable", word="unreadable", reason=str(fault))


def _of_summary(told: Summary, said: dict[str, Any], sample: str) -> Entry:
    reason, points = told.reason, told.points
    if told.fate == "interrupted":
        run = f'"{said["run"]}"' if " " in said["run"] else said["run"]
        reason = f"continue with `labrun resume {run}`"
    return Entry(
        **said, protocol=told.protocol, fate=told.fate, word=ended_as(told.fate, told.holes),
        reason=reason, began=told.began, ended=told.ended,
        samples=_lines([sample, *told.samples]), devices="\n".join(told.devices),
        holes=told.holes, resumes=told.resumes, **points.model_dump(),
        params=json.dumps(told.params), values=json.dumps(told.values),
    )  # fmt: skip


def _of_live(folder: Path, said: dict[str, Any], sample: str) -> Entry:
    """Of a run that goes on, only what it began with."""
    started = next(iter(read_records(folder / JOURNAL)), None)
    if not isinstance(started, Started):
        return Entry(**said, fate="running", word="running")
    params = brief(started.params)
    told = params.get(SAMPLE)
    return Entry(
        **said, protocol=started.protocol, fate="running", word="running",
        began=started.began or started.at, params=json.dumps(params),
        samples=_lines([sample, told if isinstance(told, str) else ""]),
        devices="\n".join(sorted(set(started.roles.values()))),
    )  # fmt: skip


def _lines(texts: list[str]) -> str:
    return "\n".join(dict.fromkeys(text for text in texts if text))
