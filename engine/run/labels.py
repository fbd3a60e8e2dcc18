"""What people say of a run: remarks of who started it from the page, and labels that may change."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ...schemas.labels import Labels
from ...system.files import write_whole

FILE = "labels.json"
LAUNCH = "launch.json"


def read_labels(folder: Path) -> Labels:
    """The labels of a run; none where nobody has given any, or the file is damaged."""
    try:
        return Labels.model_validate_json((folder / FILE).read_bytes())
    except (OSError, ValidationError):
        return Labels(tags=[])


def write_labels(folder: Path, labels: Labels) -> None:
    """Keep the labels of a run; raises OSError."""
    write_whole(folder / FILE, f"{labels.model_dump_json(indent=1)}\n".encode(), mode=0o644)


def labelled(
    labels: Labels, *, sample: str | None = None, tags: Iterable[str] = (), note: str | None = None
) -> Labels:
    """The labels with some changed; a tag with a `-` before it is taken off. Raises ValidationError."""
    kept = dict.fromkeys(labels.tags)
    for tag in tags:
        if tag.startswith("-"):
            kept.pop(tag[1:], None)
        else:
            kept[tag] = None
    return Labels(
        sample=labels.sample if sample is None else sample.strip(), tags=list(kept),
        note=labels.note if note is None else note.strip(),
    )  # fmt: skip


def read_launch(folder: Path) -> dict[str, Any]:
    """Operator, note and checklist of whoever started it from the page; {} for any other run."""
    return read_object(folder / LAUNCH)


def read_object(path: Path) -> dict[str, Any]:
    """A JSON object in a file; empty if it cannot be read."""
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        return told if isinstance(told, dict) else {}
    except (OSError, ValueError):
        return {}
