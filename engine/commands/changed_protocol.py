"""A changed protocol for a resumed run: compared with the finished work, shown, and kept."""

from collections.abc import Sequence
from pathlib import Path

from ...schemas import journal as j
from ...system.files import sync_files
from ..check import Checked
from ..journal.encode import encode
from ..journal.journal import Journal
from ..rehearse.compare import Comparison, compare
from ..run.folder import CONTRACTS, COPIES, hashes
from .options import say
from .run import keep

SHOWN = 8


def hold_against(
    folder: Path, checked: Checked, records: Sequence[j.JournalRecord], *, yes: bool
) -> list[str] | None:
    """Show the differences; returns the iterations to reopen, or None if the run cannot resume."""
    found = compare(checked, folder.name, records)
    _tell_differences(found)
    if found.undone:
        first = found.undone[0]
        say(
            f"{first.words()} at {first.path}: it was done already, and is not done twice. Nothing "
            "was sent. Resume without this change, or start a new run."
        )
        return None
    if found.doubtful and not yes:
        earlier, later = found.doubtful[0]
        more = len(found.doubtful) - 1
        say(
            f"{later} was done after the former {earlier.label} ({earlier.words()}). It"
            + (f" and {more} more" if more else "")
            + " would be kept and not done again. Nothing was sent. "
            "Add --yes if the results are still valid, or start a new run."
        )
        return None
    return found.reopened


def _tell_differences(found: Comparison) -> None:
    kinds: dict[str, list[str]] = {}
    for difference in found.differences:
        reopens = any(difference.path.startswith(f"{path}/") for path in found.reopened)
        if difference.was is not None or reopens:
            kinds.setdefault(difference.words(), []).append(difference.path)
    say(f"{found.agreeing} finished actions mean the same in the changed protocol")
    for change, paths in list(kinds.items())[:SHOWN]:
        more = f" and {len(paths) - 1} more" if len(paths) > 1 else ""
        say(f"  {change} (at {paths[0]}{more})")
    if len(kinds) > SHOWN:
        say(f"  and {len(kinds) - SHOWN} more differences")


def keep_change(
    folder: Path, checked: Checked, given: dict[str, str], journal: Journal,
    earlier: int, reopened: list[str],
) -> None:  # fmt: skip
    """Keep the changed copies first, then the record that makes them count; `earlier` changes."""
    place = folder / "changes" / str(earlier + 1)
    place.mkdir(parents=True, exist_ok=True)
    keep(place, checked, given)
    sync_files(place, CONTRACTS, COPIES)
    record = j.Changed(
        folder=place.relative_to(folder).as_posix(), files=hashes(place),
        params=encode(checked.params),
        roles={name: role.device for name, role in checked.roles.items()}, reopened=reopened,
    )  # fmt: skip
    journal.append(record)
    journal.flush()
