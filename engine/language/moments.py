"""Moments: points in time with their offset from UTC, as `now()` gives them."""

import re
from datetime import datetime, time, timedelta
from typing import Any, TypeGuard

CLOCK = re.compile(r"([01]?\d|2[0-3]):([0-5]\d)(?::([0-5]\d))?")
DATE = re.compile(r"\d{4}-\d\d-\d\d[T ].*")


def is_moment(value: Any) -> TypeGuard[datetime]:
    """True for a point in time."""
    return isinstance(value, datetime)


def moment_text(value: datetime) -> str:
    """`2026-11-24T07:00:00+01:00`; thousandths where there are some."""
    return value.isoformat(timespec="milliseconds" if value.microsecond else "seconds")


def read_moment(text: str) -> datetime:
    """The moment of a text; one without an offset is of this computer's time zone. Raises ValueError."""
    found = datetime.fromisoformat(text)
    return found if found.tzinfo is not None else found.astimezone()


def next_moment(said: Any, now: datetime) -> datetime:
    """`07:00` as the next time that a clock on the wall shows it after `now`; a date with a time; a moment.

    Raises ValueError for anything else.
    """
    if isinstance(said, datetime):
        return said
    text = said.strip() if isinstance(said, str) else ""
    if match := CLOCK.fullmatch(text):
        hour, minute, second = (int(part or 0) for part in match.groups())
        at = time(hour, minute, second)
        day = now.astimezone().date()
        today = datetime.combine(day, at).astimezone()
        tomorrow = datetime.combine(day + timedelta(days=1), at).astimezone()
        return today if today > now else tomorrow
    if DATE.fullmatch(text):
        try:
            return read_moment(text)
        except ValueError:
            pass  # said below, with what it should be
    shown = repr(said) if isinstance(said, str) else str(said)
    raise ValueError(
        f'{shown} is not a time of day or a date with a time, such as "07:00" or "2026-11-24 07:00"'
    )
