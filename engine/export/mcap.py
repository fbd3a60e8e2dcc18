"""A run as MCAP, which Foxglove and `ros2 bag` users open: goals, results, rows and the log on one time.

Messages are JSON with JSON Schemas (mcap.dev, well-known schema encoding `jsonschema`). Topics are
`/DEVICE/ACTION`, `/DEVICE/ACTION/result`, `/rows/LOOP`, `/log` (foxglove.Log) and `/journal`, which
has every record.
"""

import json
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

from mcap.writer import Writer
from ruamel.yaml import YAML

from ...schemas import journal as j
from ...schemas.lab import without_secrets
from ...system.files import replace_whole
from ..journal.journal import JournalFault, read_records
from ..run.folder import JOURNAL, LAB
from .formats import ExportFault

ATTACHED = {
    "protocol.yaml": "application/yaml", "lab.yaml": "application/yaml", "run.json": "application/json",
    "data.csv": "text/csv",
}  # fmt: skip
LOG = {
    "type": "object",
    "properties": {
        "timestamp": {
            "type": "object",
            "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}},
        },
        "level": {"type": "integer"}, "message": {"type": "string"}, "name": {"type": "string"},
    },
}  # fmt: skip
INFO, WARNING, ERROR = 2, 3, 4
"""Levels of foxglove.Log."""
Message = tuple[str, str, dict[str, Any]]


def write(folder: Path, place: Path) -> None:
    """Write the run in `folder` to the file `place`; raises ExportFault and OSError."""
    with replace_whole(place) as file:
        writer = Writer(file)
        writer.start(profile="", library="labrun")
        _write(writer, folder)
        writer.finish()


def _write(writer: Any, folder: Path) -> None:
    schemas: dict[str, int] = {}
    channels: dict[str, int] = {}
    sent: dict[str, str] = {}
    last_ns, count = 0, 0
    try:
        for record in read_records(folder / JOURNAL):
            last_ns, count = _ns(record.at), count + 1
            for topic, schema, message in _messages(record, sent):
                if schema not in schemas:
                    text = json.dumps(LOG if schema == "foxglove.Log" else {"type": "object"})
                    schemas[schema] = writer.register_schema(schema, "jsonschema", text.encode())
                if topic not in channels:
                    channels[topic] = writer.register_channel(topic, "json", schemas[schema])
                data = json.dumps(message, ensure_ascii=False).encode(errors="replace")
                writer.add_message(channels[topic], last_ns, data, last_ns)
    except JournalFault as fault:
        raise ExportFault(str(fault)) from fault
    writer.add_metadata("labrun", {"run": folder.name, "records": str(count)})
    for name, kind in ATTACHED.items():
        path = folder / name
        if path.is_file():
            data = path.read_bytes() if name != LAB else _without_tokens(path)
            writer.add_attachment(last_ns, last_ns, name, kind, data)


def _without_tokens(lab: Path) -> bytes:
    """The run's copy of its lab, which an export is passed on with: the tokens are its owner's."""
    data = YAML(typ="safe", pure=True).load(lab.read_text(encoding="utf-8"))
    return json.dumps(without_secrets(data), indent=1, ensure_ascii=False).encode()  # which is YAML


def _messages(record: j.JournalRecord, sent: dict[str, str]) -> Iterator[Message]:
    plain = record.model_dump(mode="json", exclude={"hash"}, exclude_none=True)
    yield "/journal", f"labrun.{record.kind}", plain_values(plain)
    level, words, name = INFO, "", record.kind
    match record:
        case j.GoalSent():
            topic = f"/{record.device}/{record.action}"
            sent[record.id] = topic
            yield topic, "labrun.goal", {"id": record.id, **plain_values(record.params)}
        case j.GoalEnded():
            topic = sent.pop(record.id, "/unknown")
            error = record.error.model_dump(mode="json") if record.error is not None else {}
            result = {"id": record.id, "state": record.state, **plain_values(record.result or {})}
            yield f"{topic}/result", "labrun.result", {**result, "error": error}
            if error:
                level, words, name = ERROR, f"{error['name']}: {error['message']}", topic[1:]
        case j.IterationEnded():
            if record.row is not None:
                row = {"key": record.key, **plain_values(record.row)}
                yield f"/rows/{record.loop}", "labrun.row", row
            level, words, name = WARNING if record.message else INFO, record.message, record.loop
        case j.StepEnded():
            words, name = record.message, record.path
        case j.Finished():
            level = INFO if record.fate == "succeeded" else ERROR
            words = f"{record.fate}{': ' if record.reason else ''}{record.reason}"
        case _:
            pass
    if words:
        ns = _ns(record.at)
        at = {"sec": ns // 10**9, "nsec": ns % 10**9}
        log = {"timestamp": at, "level": level, "message": words, "name": name}
        yield "/log", "foxglove.Log", log


def plain_values(value: Any) -> Any:
    """The same with quantities as `{value, unit}`: numbers that a plot finds by their path."""
    if isinstance(value, dict):
        if value.keys() == {"$quantity"}:
            number, unit = value["$quantity"]
            return {"value": number, "unit": unit}
        return {key: plain_values(one) for key, one in value.items()}
    return [plain_values(one) for one in value] if isinstance(value, list) else value


def _ns(at: str) -> int:
    moment = datetime.fromisoformat(at.replace("Z", "+00:00"))
    return int(moment.timestamp()) * 10**9 + moment.microsecond * 1000
