"""How the firmwares that speak GRBL's language differ, and what their numbers mean: a row for each."""

from collections.abc import Mapping
from dataclasses import dataclass

from .messages import (
    ALARMS,
    COMMON_ALARMS,
    COMMON_ERRORS,
    ERRORS,
    FLUIDNC_ALARMS,
    FLUIDNC_ERRORS,
)

UNKNOWN = "a number that labrun does not know"


@dataclass(frozen=True, slots=True)
class Firmware:
    """One of them; `sign` is in its banner, or in what names it otherwise."""

    name: str
    sign: str
    errors: Mapping[int, str]
    alarms: Mapping[int, str]
    unhomed: int | None = None
    """Its lock at power-up, told as this alarm, at a time of its own: it answers as before."""
    utf8: bool = False
    """It takes bytes above 127 as UTF-8, and ignores them alone."""
    own_scale: bool = False
    """Its scale begins where its configuration says, not at `-$130`."""
    off_both_ends: bool = False
    """With hard limits, its soft limits are as far from both ends as homing pulls off."""

    def error(self, code: int) -> str:
        """`error:9` with its meaning."""
        return f"error:{code} ({self.errors.get(code, UNKNOWN)})"

    def alarm(self, code: int) -> str:
        """`ALARM:1` with its meaning and what to do."""
        return f"ALARM:{code}: {self.alarms.get(code, UNKNOWN)}"


def _with_common(own: dict[int, str], common: dict[int, str], last: int) -> dict[int, str]:
    return {code: words for code, words in common.items() if code <= last} | own


GRBL = Firmware("GRBL", "", ERRORS, ALARMS)
FIRMWARES = (
    Firmware(
        "FluidNC",
        "FluidNC",
        _with_common(FLUIDNC_ERRORS, ERRORS, COMMON_ERRORS),
        _with_common(FLUIDNC_ALARMS, ALARMS, COMMON_ALARMS),
        unhomed=14,
        utf8=True,
        own_scale=True,
    ),
    Firmware("grblHAL", "HAL", ERRORS, ALARMS, off_both_ends=True),
    GRBL,
)
"""The first whose sign fits is meant. GRBL has no number of its own above those that all share."""


def firmware_of(told: str) -> Firmware:
    """By its banner (`Grbl 4.0 FluidNC v4.0.5`), or by the name that a program gives it."""
    return next(one for one in FIRMWARES if one.sign in told)
