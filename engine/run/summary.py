"""What a run came to, in a small file beside its journal: a list of runs reads no journal whole.

The journal is the truth. The summary names the journal's size and the hash of its last record; one
that does not fit them counts for nothing, and is made anew.
"""

from contextlib import suppress
from pathlib import Path

from pydantic import ValidationError

from ...schemas.summary import Summary
from ...system.files import write_whole
from ..journal.history import History, read_history
from ..journal.journal import JournalFault, Records
from .came_to import brief, samples, values
from .folder import JOURNAL, is_live

FILE = "summary.json"
TAIL = 64 * 1024


def summary_of(folder: Path) -> Summary:
    """The summary of a run, read or made; raises JournalFault if the journal cannot be read."""
    kept = kept_summary(folder)
    if kept is not None:
        return kept
    try:
        history = read_history(Records(folder / JOURNAL))
    except JournalFault:
        if not is_live(folder):
            raise
        history = History()  # it is reaching its devices
    if is_live(folder):
        return _summary(folder, history).model_copy(update={"fate": "running"})
    return keep_summary(folder, history)


def kept_summary(folder: Path) -> Summary | None:
    """The summary beside a journal, if it is the journal's."""
    try:
        kept = Summary.model_validate_json((folder / FILE).read_bytes())
        return kept if (kept.size, kept.last) == _end_of(folder / JOURNAL) else None
    except (OSError, ValidationError, ValueError):
        return None


def keep_summary(folder: Path, history: History) -> Summary:
    """Write the summary of a run that no engine is running."""
    made = _summary(folder, history)
    with suppress(OSError):  # a folder that cannot be written: the journal is read the next time
        text = f"{made.model_dump_json(indent=1)}\n"
        write_whole(folder / FILE, text.encode(), mode=0o644, sync=False)
    return made


def _summary(folder: Path, history: History) -> Summary:
    try:
        size, last = _end_of(folder / JOURNAL)
    except ValueError:
        size, last = -1, ""  # of no journal: it is read again the next time
    started, finished = history.started, history.finished
    return Summary(
        run=folder.name, size=size, last=last,
        protocol=started.protocol if started else "",
        began=(started.began or started.at) if started else "", ended=history.last_at,
        fate="interrupted" if finished is None else finished.fate,
        reason="" if finished is None else finished.reason,
        holes=history.hole_count, resumes=history.resumes, points=history.points(),
        params=brief(history.params), devices=sorted(set(history.roles.values())),
        samples=samples(folder, history.params),
        values=values(folder, finished.outputs if finished is not None else {}),
    )  # fmt: skip


def _end_of(journal: Path) -> tuple[int, str]:
    """Size, and hash of the last record; a ValueError if that is torn."""
    with journal.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(max(0, size - TAIL))
        tail = file.read()
    line = tail[:-1].rpartition(b"\n")[2] if tail.endswith(b"\n") else b""
    if not line.endswith(b'"}'):
        raise ValueError(f"the last record of {journal} is torn")
    return size, line.removesuffix(b'"}').rpartition(b'"')[2].decode()
