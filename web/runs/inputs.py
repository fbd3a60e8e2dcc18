"""A run's inputs, from its own folder: protocol, roles, parameters, the starter's remarks."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from ...engine.check import Checked, check_file
from ...engine.journal.journal import JournalFault, Records
from ...engine.run.folder import ASKED, JOURNAL, LAB, FolderFault, protocol_file
from ...engine.run.labels import LAUNCH, read_object
from ...schemas.journal import Changed
from ..models.runs import Launch
from .outline import Outline


@dataclass(slots=True)
class Inputs:
    """The latest copies of a run; `outline` is None if they can no longer be read."""

    text: str
    file: str
    checked: Checked | None
    outline: Outline | None
    launch: Launch

    @property
    def title(self) -> str:
        """The protocol's name; empty if it cannot be read."""
        protocol = self.checked.protocol if self.checked is not None else None
        return protocol.name if protocol is not None else ""


def read_inputs(folder: Path) -> Inputs:
    """Read and check a run's own copies; missing ones are left empty."""
    place = _newest(folder)
    asked = read_object(place / ASKED) or read_object(folder / ASKED)
    try:
        path = protocol_file(place)
        text = path.read_text(encoding="utf-8", errors="replace")
        checked = check_file(
            path, lab=place / LAB, bind=asked.get("roles", {}), params=asked.get("params", {}),
            needed=False,
        )  # fmt: skip
    except (FolderFault, OSError):
        return Inputs("", str(asked.get("file", "")), None, None, read_launch(folder))
    known = checked.protocol is not None and checked.survey is not None
    outline = Outline(checked) if known else None
    return Inputs(text, str(asked.get("file", "")), checked, outline, read_launch(folder))


def _newest(folder: Path) -> Path:
    """The valid copies: those of the last change that the journal knows; others never came to count."""
    place = folder
    if (folder / "changes").is_dir():
        with suppress(JournalFault):  # what is before it counts
            for record in Records(folder / JOURNAL, "changed"):
                place = folder / record.folder if isinstance(record, Changed) else place
    return place


def read_launch(folder: Path) -> Launch:
    """What the person who started it from the page entered."""
    try:
        return Launch.model_validate_json((folder / LAUNCH).read_bytes())
    except (OSError, ValidationError):
        return Launch()
