"""From a shot to its spectrum, once: what the drivers of real analysers do alike around an export."""

import errno
from hashlib import sha256

from ...schemas.messages import FileContent
from ..driver import ActionFailed, GoalContext
from .arrival import Arrived
from .book import Shot, ShotBook
from .kept import Kept


class Exporting:
    """The book's and the kept copies' part in an export."""

    def __init__(self, device: str, book: ShotBook, kept: Kept, channels: int | None) -> None:
        self.device = device
        self._book = book
        self._kept = kept
        self._channels = channels

    def channels(self) -> int:
        """How many channels a whole spectrum has: as configured, or the most that were ever seen."""
        return self._channels or int(self._book.fact("channels") or 0)

    def shot_to_export(self, name: str) -> Shot:
        """The shot, if its spectrum is kept or the analyser can still give it; raises ActionFailed."""
        shot = self._book.shot(name)
        if shot is None or shot.fate == "denied":
            raise ActionFailed("UnknownShot", f"{self.device} has made no shot {name!r}")
        if shot.exported is not None and self._kept.read(shot.name, shot.exported) is not None:
            return shot
        if shot.exported is not None:
            raise ActionFailed(
                "UnknownShot",
                f"{name} was exported before, and its copy in {self._kept.folder} is gone",
            )
        newest = self._book.newest()
        if newest is not None and newest.number != shot.number:
            raise ActionFailed(
                "UnknownShot",
                f"{self.device} exports its newest shot only, and after {name} came {newest.name} "
                f"(asked for by {newest.goal}); {name} was never exported. Export it by hand",
            )
        return shot

    def kept_file(self, shot: Shot) -> bytes | None:
        """The spectrum, where it was exported before."""
        return None if shot.exported is None else self._kept.read(shot.name, shot.exported)

    def keep(self, shot: Shot, found: Arrived) -> None:
        """Put a whole spectrum on this machine's disk: from here on the export is safe."""
        twin = self._book.shot_with(sha256(found.data).hexdigest())
        if twin is not None and twin.number != shot.number:
            raise ActionFailed(
                "Rejected",
                f"{self.device} was asked for {shot.name} and wrote the spectrum of {twin.name} again "
                f"({found.path}); look which spectrum is selected in its program",
                "unknown",
            )
        try:
            digest = self._kept.keep(shot.name, found.data)
            self._book.exported(shot, digest)
            if found.channels > int(self._book.fact("channels") or 0):
                self._book.learn("channels", str(found.channels))
        except OSError as fault:
            raise failed_to_keep(self.device, shot.name, str(self._kept.folder), fault) from fault

    def handed_over(self, goal: GoalContext, data: bytes, file: str) -> dict[str, str]:
        """The result of the action, with the file beside it."""
        digest = sha256(data).hexdigest()
        goal.files["file"] = FileContent(path=file, sha256=digest, data=data)
        return {"file": file, "sha256": digest}


def failed_to_keep(device: str, shot: str, folder: str, fault: OSError) -> ActionFailed:
    """A spectrum that this machine cannot keep: a full disk bears its own name."""
    words = (
        f"{device}: the spectrum of {shot} cannot be kept in {folder}: {fault.strerror or fault}"
    )
    if fault.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return ActionFailed("DiskFull", f"{words}; make room and ask again: nothing is lost")
    return ActionFailed("Rejected", words, "unknown")
