"""Whose spectrum is it? Proved by what is known of all others, or refused with a sentence.

A program names its files after what was typed, not after the shot. One exports the selected entry,
another its whole list (`_1.csv` the oldest); both may hold shots whose export was given up. So a
spectrum is a shot's if it was never seen before, and nothing else that it may be is left.
"""

from collections.abc import Sequence

from .export_arrival import Arrived
from .shot_log import Shot, ShotLog


class Unproved(Exception):
    """It cannot be shown which spectrum is the shot's; the text says why, and what now."""


def spectrum_of(
    shot: Shot, came: Sequence[Arrived], shot_log: ShotLog, listed: frozenset[str] | None
) -> Arrived:
    """The shot's spectrum among those of one export, `listed` being what the cache held then.

    Raises Unproved. `listed` is None where the cache cannot be seen.
    """
    fresh, known = _sorted_out(shot, came, shot_log)
    mine = _others(shot, shot_log, listed)
    if not fresh:
        raise Unproved(
            f"wrote the spectrum of {shot_log.seen_at(shot, known[0].keys)} again ({known[0].path}); "
            f"check which spectrum is selected in its program, and whether that one is right"
        )
    unclear = {name: entry for name, (entry, stored) in mine.items() if not stored}
    if known and len(known) >= len(mine):  # it exports its list: all others in it have been seen
        if len(fresh) == 1:
            return fresh[0]
        raise Unproved(_ambiguous(fresh, known, unclear))
    others = (listed or frozenset()) - {shot.entry}
    # What was listed at an earlier export and is still listed would be in a whole list.
    anchored = bool(others & shot_log.listed_before(shot))
    if unclear and (known or not anchored):
        raise Unproved(_ambiguous(fresh, known, unclear))
    fits = [one for one in fresh if one.fits]
    if len(fits) != 1 or (not anchored and 0 < len(others) < len(fresh)):
        raise Unproved(_ambiguous(fresh, known, {}))
    return fits[0]


def _sorted_out(
    shot: Shot, came: Sequence[Arrived], shot_log: ShotLog
) -> tuple[list[Arrived], list[Arrived]]:
    """Each spectrum once: those never seen before this shot, and those of earlier exports."""
    distinct: dict[str, Arrived] = {}
    for one in sorted(came, key=lambda one: not one.fits):
        distinct.setdefault(one.numbers, one)
    fresh, known = [], []
    for one in distinct.values():
        (known if shot_log.seen_at(shot, one.keys) else fresh).append(one)
    return fresh, known


def _others(
    shot: Shot, shot_log: ShotLog, listed: frozenset[str] | None
) -> dict[str, tuple[str, bool]]:
    """Earlier shots of this log that the program may still list: name -> entry, if it is stored.

    Where the cache cannot be seen, an export that brought something is taken to have emptied it, as
    the paper's server does.
    """
    earlier = shot_log.earlier(shot)
    if listed is None:
        since = shot_log.last_brought(shot)
        return {name: ("", stored) for name, _, stored in earlier if name > since}
    return {name: (entry, stored) for name, entry, stored in earlier if entry in listed}


def _ambiguous(fresh: list[Arrived], known: list[Arrived], others: dict[str, str]) -> str:
    named = ", ".join(f"{name} ({entry})" if entry else name for name, entry in others.items())
    still = f"; {named} may be among them and was never exported" if others else ""
    plural = "spectra that were" if len(fresh) > 1 else "spectrum that was"
    return (
        f"wrote {len(fresh)} {plural} never seen before"
        f"{f' and {len(known)} that were' if known else ''}{still}, so it cannot be shown which one is "
        f"this shot's. Remove all other entries from the program's list, or all that are not needed, "
        f"and export again"
    )
