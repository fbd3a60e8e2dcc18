"""The settings of a bench: in a small file beside the protocols, and who is told of runs in its lab."""

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ...schemas.lab import LabNotify
from ...system.files import write_whole
from ..models.settings import Settings
from .lab_notify import keep_notify

OF_THE_LAB = {"receivers", "quiet_from", "quiet_to"}


class SettingsFile:
    """Read at start, written at each change; defaults if the file is damaged.

    `lab` is the lab's own file, if it has one, and `served` the copy that runs from here get. What an earlier
    labrun kept of receivers here goes into the lab when settings are next written.
    """

    def __init__(
        self, path: Path, first: Settings | None = None, *, lab: Path | None = None,
        served: Path | None = None, notify: LabNotify | None = None,
    ) -> None:  # fmt: skip
        self._path, self._lab, self._served = path, lab, served
        self._now = _joined(self._load() or first or Settings(), notify)
        if served is not None:
            keep_notify(served, self._now.notify)

    def read(self) -> Settings:
        """The current settings."""
        return self._now

    def write(self, settings: Settings) -> None:
        """Store new settings; raises OSError, or ValueError if the lab's file cannot be edited."""
        for file in filter(None, (self._lab, self._served)):
            keep_notify(file, settings.notify)
        others = OF_THE_LAB if self._lab is not None else None
        write_whole(self._path, settings.model_dump_json(indent=1, exclude=others).encode())
        self._now = settings

    def _load(self) -> Settings | None:
        try:
            return Settings.model_validate_json(self._path.read_bytes())
        except (OSError, ValidationError):
            return None


def _joined(settings: Settings, notify: LabNotify | None) -> Settings:
    if notify is None:
        return settings
    known = {one.to for one in notify.receivers}
    more = [one for one in settings.receivers if one.to not in known]
    now: dict[str, Any] = {"receivers": [*notify.receivers, *more]}
    if notify.quiet_from:
        now |= {"quiet_from": notify.quiet_from, "quiet_to": notify.quiet_to}
    return settings.model_copy(update=now)
