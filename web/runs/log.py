"""The log of a run: which records are its lines; the text of a line is made on request."""

from array import array
from pathlib import Path
from typing import Any, Literal

from ..models.runs import LogLine, LogWindow
from ..report.formatting import duration, seconds_between
from .follower import read_at
from .outline import Outline

MOST_SEARCHED = 200_000
PROBLEM = 1
LINES = {
    "started", "resumed", "changed", "phase", "ended", "turn", "asked", "answered", "loop",
    "control", "safe", "touched", "again", "finished",
}  # fmt: skip


class Log:
    """Positions of the log's lines in the journal; 30 bytes per line."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.n = array("q")
        self._offset = array("q")
        self._other = array("q")
        self._flags = bytearray()
        self._device = array("h")
        self._devices: dict[str, int] = {}

    def __len__(self) -> int:
        return len(self.n)

    def take(
        self, offset: int, record: dict[str, Any], sent_offset: int = -1, device: str = ""
    ) -> bool:
        """Note a record if it is a line of the log; returns whether it is."""
        kind = record["kind"]
        is_line = kind in LINES
        is_line |= kind == "step" and bool(record.get("message"))
        is_line |= kind == "iteration" and record["fate"] == "failed"
        if not is_line:
            return False
        device = device or record.get("device", "")
        self.n.append(record["n"])
        self._offset.append(offset)
        self._other.append(sent_offset)
        self._flags.append(PROBLEM if is_problem(record) else 0)
        self._device.append(self._devices.setdefault(device, len(self._devices)))
        return True

    def window(
        self, outline: Outline | None, after: int | None, before: int | None, limit: int,
        *, problems: bool, device: str | None, find: str,
    ) -> LogWindow:  # fmt: skip
        """A window of lines: the last ones, or those next to a line's number."""
        wanted = [
            i
            for i in range(len(self.n))
            if (not problems or self._flags[i] & PROBLEM)
            and (device is None or self._device[i] == self._devices.get(device, -1))
        ]
        if find:
            words = find.casefold()
            told = self.lines(wanted[-MOST_SEARCHED:], outline)
            fits = {line.n for line in told if words in line.text.casefold()}
            wanted = [i for i in wanted if self.n[i] in fits]
        if after is not None:
            start = next((k for k, i in enumerate(wanted) if self.n[i] > after), len(wanted))
            chosen = range(start, min(len(wanted), start + limit))
        else:
            end = len(wanted)
            if before is not None:
                end = next((k for k, i in enumerate(wanted) if self.n[i] >= before), end)
            chosen = range(max(0, end - limit), end)
        return LogWindow(
            lines=self.lines([wanted[k] for k in chosen], outline), total=len(wanted),
            more_before=chosen.start > 0,
        )  # fmt: skip

    def lines(self, which: list[int], outline: Outline | None) -> list[LogLine]:
        """Lines by their positions."""
        records = read_at(self._path, [self._offset[i] for i in which])
        with_sent = [i for i in which if self._other[i] >= 0]
        sent = dict(
            zip(with_sent, read_at(self._path, [self._other[i] for i in with_sent]), strict=True)
        )
        return [
            line_of(record, sent.get(i), outline) for i, record in zip(which, records, strict=True)
        ]


def is_problem(record: dict[str, Any]) -> bool:
    """True for a failure, or a possible one."""
    match record["kind"]:
        case "ended":
            return record["state"] != "SUCCEEDED"
        case "step":
            return record["fate"] in ("failed", "unknown")
        case "iteration" | "loop":
            return record["fate"] != "succeeded"
        case "safe":
            return not record["confirmed"]
        case "finished":
            return record["fate"] != "succeeded"
        case "control":
            return record["verb"].startswith("abort")
        case "turn" | "touched" | "resumed":
            return True
        case _:
            return False


def line_of(
    record: dict[str, Any], sent: dict[str, Any] | None, outline: Outline | None
) -> LogLine:
    """One record as a line, with its step, its point and its position in the YAML."""
    level: Literal["info", "problem"] = "problem" if is_problem(record) else "info"
    path = _path(record)
    found = outline.find(path) if outline is not None and path else None
    loop, key = found.innermost if found is not None else (None, None)
    if record["kind"] == "iteration" and found is not None:
        loop, key = found.step.told.path, record["key"]
    return LogLine(
        n=record["n"], at=record["at"], level=level, kind=record["kind"],
        text=_text(record, sent), device=record.get("device") or (sent or {}).get("device"),
        path=path, node=found.step.told.path if found is not None else None,
        loop=loop, key=key, line=found.step.told.line if found is not None else None,
    )  # fmt: skip


def _path(record: dict[str, Any]) -> str:
    if record["kind"] == "ended":
        return record["id"].partition("/")[2].rpartition("/")[0]
    if record["kind"] == "iteration":
        return record["loop"]
    return record.get("path") or record.get("loop") or ""


def _text(record: dict[str, Any], sent: dict[str, Any] | None) -> str:
    match record["kind"]:
        case "started":
            return f"started with labrun {record['labrun']}"
        case "resumed":
            return f"resumed (resume {record['count']}) with labrun {record['labrun']}"
        case "changed":
            return f"continues with a changed protocol ({record['folder']})"
        case "phase":
            name = str(record["phase"]).partition(":")[0]
            return "the protocol" if name == "main" else name
        case "ended":
            return _goal(record, sent)
        case "step":
            return record["message"]
        case "turn":
            error = record.get("error") or {}
            why = f" after {error.get('name')}: {error.get('message', '')}" if error else ""
            return f"turn {record['turn']}{why}".rstrip(": ")
        case "asked":
            return f"? {record['text']} [{'/'.join(record['choices'])}]"
        case "answered":
            return f"answered {record['choice']} by {record['by']}"
        case "iteration":
            return f"{record['key']}: {record.get('message') or 'failed'} (a hole)"
        case "loop":
            return (
                f"loop ended: {record['succeeded']} ok, {record['failed']} failed, "
                f"{record['skipped']} skipped"
            )
        case "control":
            return f"{record['verb']} by {record['by']}"
        case "safe":
            words = "safe state confirmed" if record["confirmed"] else "safe state NOT confirmed"
            return f"{record['device']}: {words}" + _more(record.get("message"))
        case "touched":
            return f"{record['device']}: {record['reason']}"
        case "again":
            return "the failed step is retried" + _more(record.get("by"))
        case _:
            return f"run {record.get('fate', '')}" + _more(record.get("reason"))


def _goal(record: dict[str, Any], sent: dict[str, Any] | None) -> str:
    label = f"{sent['device']}.{sent['action']}" if sent is not None else record["id"]
    if sent is not None:
        attempt = record["id"].rpartition("/")[2]
        label += f" (try {attempt})" if attempt != "1" else ""
    took = f" {duration(seconds_between(sent['at'], record['at']))}" if sent is not None else ""
    if record["state"] == "SUCCEEDED":
        return f"{label} ok{took}"
    error = record.get("error") or {}
    name = error.get("name", record["state"].lower())
    return f"{label} {name}{took}{_more(error.get('message'))}"


def _more(text: str | None) -> str:
    return f": {text}" if text else ""
