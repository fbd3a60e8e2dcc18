"""From a shot to its spectrum, once: the export steps that drivers of real analysers share."""

import errno
import time

from ...schemas.messages import FileContent
from ..driver import ActionFailed, GoalContext
from .export_arrival import Arrived
from .identity import Unproved, spectrum_of
from .shot_log import Shot, ShotLog
from .spectrum_store import SpectrumStore

UNKNOWN_TIMES = 5
"""A program may rest between two lines of a file: as long as it is not known how many there will be,
the file has to stay the same for so many times as long."""


class Exporting:
    """The part of an export done by the shot log and the stored copies."""

    def __init__(
        self, device: str, shot_log: ShotLog, kept: SpectrumStore, channels: int | None
    ) -> None:
        self.device = device
        self._shot_log = shot_log
        self._spectra_kept = kept
        self._channels = channels

    def channels(self) -> int:
        """How many channels a complete spectrum has: as configured, or the most seen so far."""
        return self._channels or int(self._shot_log.fact("channels") or 0)

    def settle_s(self, known_s: float) -> float:
        """How long a file must stay the same to be complete; `known_s` where its channels can be counted."""
        return known_s if self.channels() else UNKNOWN_TIMES * known_s

    def shot_to_export(self, name: str) -> Shot:
        """The shot, if its spectrum is stored or the analyser still has it; raises ActionFailed."""
        shot = self._shot_log.shot(name)
        if shot is None or shot.fate == "denied":
            raise ActionFailed("UnknownShot", f"{self.device} has no shot {name!r}")
        if (
            shot.exported is not None
            and self._spectra_kept.read(shot.name, shot.exported) is not None
        ):
            return shot
        if shot.exported is not None:
            raise ActionFailed(
                "UnknownShot",
                f"{name} was exported before, and its copy in {self._spectra_kept.folder} is gone",
            )
        newest = self._shot_log.newest()
        if newest is not None and newest.number != shot.number:
            raise ActionFailed(
                "UnknownShot",
                f"{self.device} exports its newest shot only, and after {name} came {newest.name} "
                f"(requested by {newest.goal}); {name} was never exported. Export it by hand",
            )
        return shot

    def kept_file(self, shot: Shot) -> bytes | None:
        """The spectrum, if it was exported before."""
        return None if shot.exported is None else self._spectra_kept.read(shot.name, shot.exported)

    def keep(
        self, shot: Shot, came: list[Arrived], before: frozenset[str] | None, after: set[str] | None
    ) -> Arrived:
        """Prove which spectrum is the shot's and write it to this machine's disk: then it is safe.

        `before` and `after` are what the cache held, None if it cannot be seen. What is not proved is
        set aside in `quarantine`, beside the stored spectra.
        """
        try:
            try:
                found = self._proved(shot, came, before, after)
            except Unproved as fault:
                raise self._set_aside(shot, came, str(fault)) from fault
            finally:
                self._shot_log.saw(shot, {key for one in came for key in one.keys}, before)
            digest = self._spectra_kept.keep(shot.name, found.data)
            self._shot_log.exported(shot, digest)
            if found.channels > int(self._shot_log.fact("channels") or 0):
                self._shot_log.learn("channels", str(found.channels))
        except OSError as fault:
            raise failed_to_keep(
                self.device, shot.name, str(self._spectra_kept.folder), fault
            ) from fault
        return found

    def _proved(
        self, shot: Shot, came: list[Arrived], before: frozenset[str] | None, after: set[str] | None
    ) -> Arrived:
        expected = None if shot.before is None else shot.before | {shot.entry}
        for listed in (before, after):
            if listed is not None and expected is not None and not listed <= expected:
                new = ", ".join(sorted(name for name in listed if name not in expected))
                raise Unproved(
                    f"has measured for somebody else since then: {new} is new in its cache. Remove it "
                    f"from the program's list and export again"
                )
        return spectrum_of(shot, came, self._shot_log, before)

    def _set_aside(self, shot: Shot, came: list[Arrived], why: str) -> ActionFailed:
        """The files of an export that proves nothing, copied to where nobody takes them for proved."""
        words = f"{self.device} was asked for {shot.name} and {why}. Nothing was deleted by labrun"
        name = f"{shot.name}_{time.strftime('%Y%m%d_%H%M%S')}"
        files = {one.path: one.data for one in came}
        place = self._spectra_kept.set_aside(name, files, words)
        self._shot_log.forget_export(shot)
        return ActionFailed("Rejected", f"{words}; what came is in {place}", "unknown")

    def handed_over(self, goal: GoalContext, data: bytes, file: str) -> dict[str, str]:
        """The result of the action, with the file beside it."""
        goal.files["file"] = sent = FileContent.of(file, data)
        return {"file": file, "sha256": sent.sha256}


def failed_to_keep(device: str, shot: str, folder: str, fault: OSError) -> ActionFailed:
    """A spectrum that this machine cannot store: a full disk has its own error name."""
    words = (
        f"{device}: the spectrum of {shot} cannot be stored in {folder}: {fault.strerror or fault}"
    )
    if fault.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return ActionFailed("DiskFull", f"{words}; free some space and try again: nothing is lost")
    return ActionFailed("Rejected", words, "unknown")
