"""What the analyser server's answers mean, and whether a shot was fired.

The server answers `success` or the text of whatever exception was raised. Only texts that are
raised before the click mean that nothing happened; any other leaves it open.
"""

import contextlib
import re
import time
from dataclasses import dataclass
from typing import Any

from ...schemas.contract import Happened

SUCCESS = "success"
BUSY = "The analyzer is currently running"
NOT_FOUND = ("The button ", " was not found.")
TOO_LONG = "The operation takes too long"
TIME = re.compile(r"(?=(\d{4}(?:_\d\d){5}))")
FULL = ("No space left on device", "[Errno 28]", "[WinError 112]")


@dataclass(frozen=True, slots=True)
class Meaning:
    """The contract's error name for an answer, whether it happened, and what to do now."""

    error: str
    happened: Happened
    now: str


def text_of(answer: tuple[Any, ...]) -> str:
    """The text of the answer: its first part (`analyze` answers with two)."""
    return str(answer[0]) if answer else ""


def meaning_of(text: str) -> Meaning | None:
    """What an answer that is not `success` means; None for success."""
    if text == SUCCESS:
        return None
    if text.startswith(BUSY):
        return Meaning("Busy", "no", "nothing was clicked; try again when it is idle")
    if text.startswith(NOT_FOUND[0]) and text.endswith(NOT_FOUND[1]):
        # Raised before the click of the first button of a measurement. An export may have clicked
        # others before it, but an export may be repeated.
        return Meaning("ButtonNotFound", "no", "find its buttons again with `locate`")
    if text.startswith(TOO_LONG):
        return Meaning("Timeout", "unknown", "it clicked, but saw no result")
    if any(sign in text for sign in FULL):
        return Meaning("DiskFull", "unknown", "free space on the analyser's disk")
    return Meaning("Rejected", "unknown", "check the analyser's program")


def times_in(name: str) -> list[float]:
    """The times in an export's name, on the server's clock, in seconds since 1970.

    The server types its time into a field that it does not empty: from its second export on, a name
    holds those of earlier ones, too, and even inside each other.
    """
    times = []
    for text in TIME.findall(name):
        with contextlib.suppress(ValueError, OverflowError):
            times.append(time.mktime(time.strptime(text, "%Y_%m_%d_%H_%M_%S")))
    return times
