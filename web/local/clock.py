"""Times as sent to the page: ISO 8601, UTC, with milliseconds."""

import time
from datetime import UTC, datetime


def iso(seconds: float) -> str:
    """Seconds since 1970."""
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds")


def now_iso() -> str:
    """This instant."""
    return iso(time.time())


def since_1970(text: str) -> float:
    """Back to seconds since 1970."""
    return datetime.fromisoformat(text).timestamp()
