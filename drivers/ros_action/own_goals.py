"""Goals that the driver has under way, on disk: what was lost from sight, or left by a killed session."""

import json
from pathlib import Path

from ...system.files import write_whole

FILE = "goals.json"


class OwnGoals:
    """Id -> action of the contract; written before a goal is sent.

    `left`: of earlier sessions, and those of this one that nobody follows any more.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / FILE
        self._now: dict[bytes, str] = {}
        self.left = self._read()

    def begin(self, id: bytes, action: str) -> None:
        """Before a goal is sent; raises OSError."""
        self._now[id] = action
        self._write()

    def end(self, id: bytes) -> None:
        """It has ended, or was never sent."""
        self._now.pop(id, None)
        self.left.pop(id, None)
        self._write()

    def lose(self, id: bytes) -> None:
        """Nobody follows it any more, and it has not ended as far as is known."""
        if id in self._now:
            self.left[id] = self._now.pop(id)

    def _read(self) -> dict[bytes, str]:
        try:
            return {
                bytes.fromhex(id): name for id, name in json.loads(self._path.read_bytes()).items()
            }
        except (OSError, ValueError, AttributeError):
            return {}

    def _write(self) -> None:
        kept = {id.hex(): name for id, name in {**self.left, **self._now}.items()}
        write_whole(self._path, json.dumps(kept).encode(), sync=False)
