"""Files beside a protocol that its actions send to devices, such as a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..language.fold import fold
from ..language.used_files import FileFault, find_file
from ..language.value import Value
from .spots import Spot

if TYPE_CHECKING:
    from .survey import Survey

LARGEST = 50_000_000
"""Bytes that go along with a goal."""


def known_text(spot: Spot) -> str | None:
    """The text of an argument, if it is known before the run and the same in every iteration."""
    value = spot.value
    if not isinstance(value, Value) or spot.inferred()[1]:
        return None
    folded = fold(value, spot.env.folding())
    found = folded.value if folded.known and not folded.loops else None
    return found if isinstance(found, str) and found else None


def named_files(survey: Survey) -> tuple[dict[str, Spot], list[Spot]]:
    """The arguments that name files to read, by names known beforehand; and all that name files to write."""
    read: dict[str, Spot] = {}
    written: list[Spot] = []
    for _, at, _, action in survey.actions():
        into, out_of = action.path_params()
        for spot in (at.arguments[name] for name in into if name in at.arguments):
            text = known_text(spot)
            if text is not None:
                read.setdefault(text, spot)
        written += [at.arguments[name] for name in out_of if name in at.arguments]
    return read, written


def sent_files(survey: Survey) -> dict[str, Path]:
    """By the names that the protocol gives them; those that the run itself makes are none of them."""
    read, written = named_files(survey)
    files = {}
    for name in read.keys() - {known_text(spot) for spot in written}:
        try:
            files[name] = find_file(survey.source.path, name, LARGEST, survey.opened.folders)[0]
        except FileFault:
            continue  # a step may make it; if none does, the goal says that it is not there
    return dict(sorted(files.items()))
