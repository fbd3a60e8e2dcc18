"""Times, durations, numbers and values formatted for a reader."""

import re
from datetime import UTC, datetime
from typing import Any

from ...engine.journal.encode import QUANTITY_KEY

VARIABLE = re.compile(r"\d+(?:\.\d+)?")


def moment(at: str) -> str:
    """`2026-11-21 07:36:22`, in UTC, from a record's time."""
    return at[:19].replace("T", " ")


def local_time(at: str) -> datetime:
    """A record's time as a datetime; the epoch for a record without one."""
    try:
        return datetime.fromisoformat(at).astimezone(UTC)
    except ValueError:
        return datetime.fromtimestamp(0, UTC)


def seconds_between(start: str, end: str) -> float:
    """Seconds from start to end; never negative, even if a clock was set back."""
    return max(0.0, (local_time(end) - local_time(start)).total_seconds())


def duration(seconds: float) -> str:
    """`12 ms`, `3.4 s`, `4 min 05 s`, `2 h 03 min`, `3 d 04 h`."""
    if seconds < 0.9995:
        return f"{seconds * 1000:.0f} ms"
    if seconds < 59.95:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    for unit, part, length, fraction in (("min", "s", 60, 1), ("h", "min", 3600, 60)):
        if whole < 60 * length:
            return f"{whole // length} {unit} {whole % length // fraction:02d} {part}"
    return f"{whole // 86400} d {whole % 86400 // 3600:02d} h"


def size(number: int) -> str:
    """`512 B`, `3.4 kB`, `12.0 MB`: decimal units."""
    if number < 1000:
        return f"{number} B"
    amount = float(number)
    for unit in ("kB", "MB", "GB"):
        amount /= 1000
        if amount < 999.95:
            return f"{amount:.1f} {unit}"
    return f"{amount / 1000:.1f} TB"


def count(number: int, one: str, many: str = "") -> str:
    """`1 hole`, `1,071 points`."""
    return f"{number:,} {one if number == 1 else many or one + 's'}"


def value(told: Any) -> str:
    """A journal value as text: quantities with their unit, lists in brackets."""
    if isinstance(told, dict) and QUANTITY_KEY in told:
        magnitude, unit = split_quantity(told)
        return f"{magnitude} {unit}".rstrip()
    if isinstance(told, dict):
        return "{" + ", ".join(f"{name}: {value(item)}" for name, item in told.items()) + "}"
    if isinstance(told, list):
        return "[" + ", ".join(value(item) for item in told) + "]"
    if isinstance(told, bool) or told is None:
        return {True: "yes", False: "no", None: "none"}[told]
    return f"{told:.12g}" if isinstance(told, float) else str(told)


def split_quantity(told: dict[str, Any]) -> tuple[str, str]:
    """Number and unit of a quantity in the journal."""
    magnitude, unit = told[QUANTITY_KEY]
    number = f"{magnitude:.12g}" if isinstance(magnitude, int | float) else value(magnitude)
    return number, str(unit)


def pattern(text: str) -> str:
    """A text with its numbers masked: texts that are then equal describe the same thing."""
    return VARIABLE.sub("#", text)
