"""The lab's `notify`, edited where it stands: every other line of the file stays as it is."""

import json
import re
from pathlib import Path
from typing import Any

from ...engine.language.source import parse_source
from ...engine.new.device.entry import flow
from ...schemas.lab import LabNotify
from ...system.files import write_whole

BLOCK = re.compile(r"^notify:.*\n?(?:(?:[ \t#-].*)?\n)*(?:[ \t#-].*)?", re.MULTILINE)
"""The key with all that is indented below it."""
PLAIN = re.compile(r"\$\w+|[a-z]+://[\w.:/@+%?=&~-]*\w|to|on|question|failed|done|device_lost")
"""Texts of a `notify` that mean themselves without quotation marks."""


def keep_notify(path: Path, notify: LabNotify | None) -> None:
    """Write it into a lab's file, or take it out; raises OSError, or ValueError where that cannot be done."""
    text = path.read_text(encoding="utf-8")
    before = _read(text, path)
    if _same(before.get("notify"), notify):
        return
    wanted = notify.model_dump(mode="json", exclude_defaults=True) if notify is not None else None
    after = {name: value for name, value in before.items() if name != "notify"}
    if wanted is not None:
        after["notify"] = wanted
    made = _edited(text, wanted, before)
    if _read(made, path) != after:
        raise ValueError(
            f"{path} is written in a way that cannot be edited here: write `notify` by hand"
        )
    write_whole(path, made.encode())


def _same(written: Any, notify: LabNotify | None) -> bool:
    if written is None or notify is None:
        return written is None and notify is None
    known = LabNotify.model_validate(written)
    return known.model_copy(update={"to": known.receivers, "on": notify.on}) == notify


def _edited(text: str, wanted: dict[str, Any] | None, before: dict[str, Any]) -> str:
    if text.lstrip().startswith("{"):
        rest = {name: value for name, value in before.items() if name != "notify"}
        return json.dumps(rest | ({"notify": wanted} if wanted else {}), indent=1) + "\n"
    block = "" if wanted is None else _block(wanted)
    if BLOCK.search(text):
        return BLOCK.sub(lambda found: block + _tail(found[0]), text, count=1)
    return text + "\n" * (not text.endswith("\n")) + block


def _tail(block: str) -> str:
    """Blank lines and comments behind it belong to what follows."""
    lines = block.splitlines(keepends=True)
    kept = len(lines)
    while kept > 1 and (not lines[kept - 1].strip() or lines[kept - 1].startswith("#")):
        kept -= 1
    return "".join(lines[kept:])


def _block(wanted: dict[str, Any]) -> str:
    to = "".join(f"    - {flow(one, _text)}\n" for one in wanted["to"])
    rest = "".join(f"  {n}: {json.dumps(v)}\n" for n, v in wanted.items() if n != "to")
    return f"notify:\n  to:\n{to}{rest}"


def _text(text: str) -> str:
    """With quotation marks only where YAML needs them."""
    return text if PLAIN.fullmatch(text) else json.dumps(text, ensure_ascii=False)


def _read(text: str, path: Path) -> dict[str, Any]:
    source, problems = parse_source(text, path, path.name)
    if source is None or not isinstance(source.data, dict):
        raise ValueError(f"{path}: {problems[0].message if problems else 'it is no lab'}")
    return source.data
