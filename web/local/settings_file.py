"""The settings of a bench, in a small file beside the protocols."""

from pathlib import Path

from pydantic import ValidationError

from ...system.files import write_whole
from ..models.settings import Settings


class SettingsFile:
    """Read at start, written at each change; defaults if the file is damaged."""

    def __init__(self, path: Path, first: Settings | None = None) -> None:
        self._path = path
        self._now = self._load() or first or Settings()

    def read(self) -> Settings:
        """The current settings."""
        return self._now

    def write(self, settings: Settings) -> None:
        """Store new settings."""
        write_whole(self._path, settings.model_dump_json(indent=1).encode())
        self._now = settings

    def _load(self) -> Settings | None:
        try:
            return Settings.model_validate_json(self._path.read_bytes())
        except (OSError, ValidationError):
            return None
