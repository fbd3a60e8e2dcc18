"""Quick summary of a finished run: from its first and last records, without those between."""

import json
from pathlib import Path
from typing import Any

from ...engine.run.folder import ASKED, JOURNAL
from ..models.runs import RunSummary
from .inputs import read_launch, read_mapping

TAIL = 256 * 1024
SEARCHED = 4 * 1024 * 1024


def quick_summary(folder: Path) -> RunSummary | None:
    """The summary of a run whose last record is `finished`; None for any other.

    None also for a journal without what a summary needs: opening the run tells what is wrong.
    """
    try:
        return _summary(folder)
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return None


def _summary(folder: Path) -> RunSummary | None:
    path = folder / JOURNAL
    with path.open("rb") as file:
        started = json.loads(file.readline())
        size = path.stat().st_size
        file.seek(max(0, size - TAIL))
        records = _records(file.read())
    if not records or records[-1].get("kind") != "finished" or started.get("kind") != "started":
        return None
    finished = records[-1]
    loops = [r for r in records if r["kind"] == "loop" and r["loop"].startswith("main/")]
    newest = {record["loop"]: record for record in loops}.values()
    launch = read_launch(folder)
    return RunSummary(
        id=folder.name, protocol=started.get("protocol", ""),
        file=str(read_mapping(folder / ASKED).get("file", "")),
        fate=finished["fate"], reason=finished.get("reason", ""), live=False,
        began_at=started.get("began") or started["at"], ended_at=finished["at"],
        done=sum(record["total"] for record in newest),
        failed=sum(record["failed"] for record in newest),
        total=sum(record["total"] for record in newest) or None,
        holes=finished.get("holes", 0), resumes=_resumes(path, size), operator=launch.operator,
    )  # fmt: skip


def _records(tail: bytes) -> list[dict[str, Any]]:
    found = []
    for line in tail.split(b"\n")[:-1]:
        try:
            found.append(json.loads(line))
        except ValueError:
            continue  # the first line of a tail is incomplete
    return [record for record in found if isinstance(record, dict) and "kind" in record]


def _resumes(path: Path, size: int) -> int:
    if size > SEARCHED:
        return 0
    return path.read_bytes().count(b'"kind":"resumed"')
