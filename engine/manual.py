"""The manual of problems: what a code means, why, and protocols that pass and fail."""

from inspect import getdoc
from types import ModuleType

from . import bind, lab, params
from .check import CHECKS
from .language import shape, source

FAMILIES: tuple[ModuleType, ...] = (source, shape, lab, bind, params, *CHECKS)


def all_codes() -> dict[str, str]:
    """Code -> what it is, for every problem that there is."""
    return {code: title for family in FAMILIES for code, title in sorted(family.CODES.items())}


def page(code: str) -> str | None:
    """The page of a code: its title and, for a check, its family's page; None for no code."""
    for family in FAMILIES:
        if code in family.CODES:
            title = f"{code}: {family.CODES[code]}"
            return f"{title}\n\n{getdoc(family)}" if family in CHECKS else title
    return None
