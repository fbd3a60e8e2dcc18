"""A changed protocol for a run that has begun: compared with the finished work, told, and kept."""

import json
import shutil
from collections.abc import Iterable
from pathlib import Path

from ...schemas import journal as j
from ...system.files import sync_files, sync_folder
from ..check import Checked, check_file
from ..journal.encode import encode
from ..run.folder import ASKED, CONTRACTS, COPIES, LAB, FolderFault, hashes, protocol_file
from .begin import keep
from .compare import Comparison

SHOWN = 8


def check_copy(
    place: Path, changed: Path | None = None, params: dict[str, str] | None = None
) -> tuple[Checked, dict[str, str]]:
    """Check the run's own copies, or a changed protocol instead; and the parameters given."""
    try:
        asked = json.loads((place / ASKED).read_text(encoding="utf-8"))
    except (OSError, ValueError) as fault:
        raise FolderFault(f"{place / ASKED} cannot be read: {fault}") from fault
    given = {**asked["params"], **(params or {})}
    checked = check_file(
        changed or protocol_file(place), lab=place / LAB, bind=asked["roles"], params=given
    )
    if checked.lab is not None:
        checked.lab.served_as = asked.get("served_as", "")
    return checked, given


def why_not(found: Comparison, *, yes: bool) -> str:
    """Why finished work does not allow a change, and what now; empty if it does."""
    if found.undone:
        first = found.undone[0]
        place = "Steps without an `id` are known by their place: put new ones behind those done. "
        return (
            f"{first.words()} at {first.path}: it was done already, and is not done twice. Nothing "
            f"was sent. {place if first.instead_of else ''}Go on without this change, or start a new run."
        )
    if found.doubtful and not yes:
        earlier, later = found.doubtful[0]
        more = len(found.doubtful) - 1
        return (
            f"{later} was done after the former {earlier.label} ({earlier.words()}). It"
            + (f" and {more} more" if more else "")
            + " would be kept and not done again. Nothing was sent. "
            "Add --yes if the results are still valid, or start a new run."
        )
    return ""


def differences(found: Comparison) -> Iterable[str]:
    """What a change means for finished work, line by line."""
    kinds: dict[str, list[str]] = {}
    for difference in found.differences:
        reopens = any(difference.path.startswith(f"{path}/") for path in found.reopened)
        if difference.was is not None or reopens:
            kinds.setdefault(difference.words(), []).append(difference.path)
    yield f"{found.agreeing} finished actions mean the same in the changed protocol"
    for change, paths in list(kinds.items())[:SHOWN]:
        more = f" and {len(paths) - 1} more" if len(paths) > 1 else ""
        yield f"  {change} (at {paths[0]}{more})"
    if len(kinds) > SHOWN:
        yield f"  and {len(kinds) - SHOWN} more differences"


def keep_change(
    folder: Path, checked: Checked, given: dict[str, str], earlier: int, reopened: list[str]
) -> j.Changed:
    """Keep the changed copies, after `earlier` changes; the record makes them count once it is written."""
    place = folder / "changes" / str(earlier + 1)
    shutil.rmtree(place, ignore_errors=True)  # of a change that never came to count
    place.mkdir(parents=True)
    keep(place, checked, given)
    sync_files(place, CONTRACTS, COPIES)
    sync_folder(folder)
    return j.Changed(
        folder=place.relative_to(folder).as_posix(), files=hashes(place),
        params=encode(checked.params),
        roles={name: role.device for name, role in checked.roles.items()}, reopened=reopened,
    )  # fmt: skip
