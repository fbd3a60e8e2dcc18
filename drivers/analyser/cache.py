"""The folder in which the analyser's program keeps its shots: entries are identified by name."""

import asyncio
import shutil
from fnmatch import fnmatch
from pathlib import Path

from .folder import SharedFolder

LOOK_S = 0.2


class Cache:
    """Entries whose names match `pattern`; a name that is new since a click is that click's shot."""

    def __init__(self, place: str, pattern: str = "*") -> None:
        self.place = place
        self._folder = SharedFolder(place)
        self._pattern = pattern

    async def names(self) -> set[str]:
        """What is in it now; raises FolderFault."""
        return {name for name in await self._folder.names() if fnmatch(name, self._pattern)}

    async def names_when_gone(self, name: str, timeout_s: float) -> set[str]:
        """What is left once `name` has gone, or when the time is up."""
        loop = asyncio.get_running_loop()
        end = loop.time() + timeout_s
        while True:
            names = await self.names()
            if name not in names or loop.time() >= end:
                return names
            await asyncio.sleep(LOOK_S)

    async def remove(self, name: str) -> None:
        """Delete one entry, a file or a folder; raises OSError."""
        path = Path(self.place) / name
        if path.parent != Path(self.place) or name in ("", ".", ".."):
            raise OSError(f"{name!r} is not an entry of {self.place}")
        if path.is_dir():
            await asyncio.to_thread(shutil.rmtree, path)
        else:
            await asyncio.to_thread(path.unlink)
