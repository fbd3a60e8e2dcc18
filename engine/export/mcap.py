"""A run as MCAP, which Foxglove and `ros2 bag` users open: goals, results, rows and the log on one time.

Messages are JSON with JSON Schemas (mcap.dev, well-known schema encoding `jsonschema`). Topics are
`/DEVICE/ACTION`, `/DEVICE/ACTION/result`, `/rows/LOOP`, `/log` (foxglove.Log) and `/journal`, which
has every record. What a program offers for plots it takes from a schema's properties, so each topic has a
schema of its own, made from its messages: one reading of the journal for it, and one to write.
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
RECORDS = "/journal"
MIXED: dict[str, Any] = {}
"""The schema of what is a number in one message and a text in another; programs are not told of it."""
Schema = dict[str, Any]


def write(folder: Path, place: Path) -> None:
    """Write the run in `folder` to the file `place`; raises ExportFault and OSError."""
    with replace_whole(place) as file:
        writer = Writer(file)
        writer.start(profile="", library="labrun")
        _write(writer, folder)
        writer.finish()


def _write(writer: Any, folder: Path) -> None:
    schemas: dict[str, Schema | None] = {}
    channels: dict[str, int] = {}
    last_ns, count = 0, 0
    try:
        for _, topic, message in _read(folder):
            schemas[topic] = _widened(schemas.get(topic), message)
        for topic, schema in schemas.items():
            name = "foxglove.Log" if topic == "/log" else f"labrun{topic.replace('/', '.')}"
            text = json.dumps(LOG if topic == "/log" else _kept(schema))
            number = writer.register_schema(name, "jsonschema", text.encode())
            channels[topic] = writer.register_channel(topic, "json", number)
        for last_ns, topic, message in _read(folder):
            count += topic == RECORDS
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


def _widened(known: Schema | None, value: Any) -> Schema | None:
    """The JSON Schema of values, with one more; None of what has only been null."""
    if value is None:
        return known
    if isinstance(value, (dict, list)):
        kind = "object" if isinstance(value, dict) else "array"
        known = {"type": kind, "properties": {}} if known is None else known
        if known.get("type") != kind:
            return MIXED
        of = known["properties"]
        for name, one in value.items() if isinstance(value, dict) else (("", v) for v in value):
            of[name] = _widened(of.get(name), one)
        return known
    kind = {bool: "boolean", str: "string"}.get(type(value), "number")
    return {"type": kind} if known in (None, {"type": kind}) else MIXED


def _kept(schema: Schema | None) -> Schema | None:
    """What Foxglove reads of it, which refuses a file for a property of no type, and lists in lists."""
    if not schema or "properties" not in schema:
        return schema or None
    found = {name: kept for name, one in schema["properties"].items() if (kept := _kept(one))}
    if schema["type"] == "object":
        return {"type": "object", "properties": found}
    items = found.get("")
    return {"type": "array", "items": items} if items and items["type"] != "array" else None


def _read(folder: Path) -> Iterator[tuple[int, str, dict[str, Any]]]:
    """When, on which topic, what: the whole journal; raises JournalFault."""
    sent: dict[str, str] = {}
    for record in read_records(folder / JOURNAL):
        for topic, message in _messages(record, sent):
            yield _ns(record.at), topic, message


def _messages(
    record: j.JournalRecord, sent: dict[str, str]
) -> Iterator[tuple[str, dict[str, Any]]]:
    plain = record.model_dump(mode="json", exclude={"hash"}, exclude_none=True)
    yield RECORDS, plain_values(plain)
    level, words, name = INFO, "", record.kind
    match record:
        case j.GoalSent():
            topic = f"/{record.device}/{record.action}"
            sent[record.id] = topic
            yield topic, {"id": record.id, **plain_values(record.params)}
        case j.GoalEnded():
            topic = sent.pop(record.id, "/unknown")
            error = record.error.model_dump(mode="json") if record.error is not None else {}
            result = {"id": record.id, "state": record.state, **plain_values(record.result or {})}
            yield f"{topic}/result", {**result, "error": error}
            if error:
                level, words, name = ERROR, f"{error['name']}: {error['message']}", topic[1:]
        case j.IterationEnded():
            if record.row is not None:
                row = {"key": record.key, **plain_values(record.row)}
                yield f"/rows/{record.loop}", row
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
        yield "/log", log


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
