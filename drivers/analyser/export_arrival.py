"""Wait until the file that an export writes is complete.

"Success" is reported while the CSV is still being written (55 of 365 kB, measured), so a file is
accepted when its size has not changed for a while, every line is readable and no channel is missing.
"""

import asyncio
from dataclasses import dataclass
from fnmatch import fnmatch

from .folder import Folder, FolderFault
from .spectrum_csv import Incomplete, channels_of

LOOK_S = 0.25
NO_ROOM = 1_000_000
"""Bytes: with less than that free, an export that stays incomplete is reported as a full disk."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to wait for: a new file whose name matches `pattern`, with at least `channels` channels.

    `name` is part of its path if the export was given a name; `before` is what was in the
    folder when the export was requested.
    """

    before: frozenset[str]
    pattern: str
    channels: int = 0
    name: str = ""
    settle_s: float = 1.0


@dataclass(frozen=True, slots=True)
class Arrived:
    """A complete spectrum: where it was found, its bytes, its channels."""

    path: str
    data: bytes
    channels: int


class NotArrived(Exception):
    """No complete file arrived; the text says what is there. `full` if its disk is full."""

    def __init__(self, text: str, full: bool = False) -> None:
        super().__init__(text)
        self.full = full


async def arrived(folder: Folder, wanted: Wanted, timeout_s: float) -> Arrived:
    """The spectrum, as soon as it is complete; raises NotArrived."""
    loop = asyncio.get_running_loop()
    end = loop.time() + timeout_s
    seen: dict[str, int] = {}
    still_since = loop.time()
    why = "there is nothing new"
    while True:
        try:
            sizes = await _new_files(folder, wanted)
            if sizes != seen:
                seen, still_since = sizes, loop.time()
            if sizes and loop.time() - still_since >= wanted.settle_s:
                return await _whole(folder, wanted, sizes)
            why = _words(sizes) or why
        except (Incomplete, FolderFault) as fault:
            why = str(fault)
        if loop.time() >= end:
            raise NotArrived(f"{why}, {timeout_s:g} s after it was requested", await _full(folder))
        await asyncio.sleep(LOOK_S)


async def _new_files(folder: Folder, wanted: Wanted) -> dict[str, int]:
    new = sorted(await folder.names() - wanted.before)
    if any(wanted.name in name for name in new):
        new = [name for name in new if wanted.name in name]
    sizes: dict[str, int] = {}
    for name in new:
        sizes |= await folder.files(name)
    return sizes


async def _whole(folder: Folder, wanted: Wanted, sizes: dict[str, int]) -> Arrived:
    """The one file that matches, read in full; raises Incomplete."""
    paths = [path for path in sizes if fnmatch(path.rpartition("/")[2], wanted.pattern)]
    if not paths:
        raise Incomplete(f"{_words(sizes)}; none is called {wanted.pattern}")
    if len(paths) > 1:
        raise Incomplete(
            f"{', '.join(paths)} are all new and called {wanted.pattern}; it is unclear which "
            f"one belongs to this shot"
        )
    (path,) = paths
    data = await folder.read(path)
    if len(data) != sizes[path]:
        raise Incomplete(f"{path} is still growing")
    try:
        channels = channels_of(data)
    except Incomplete as fault:
        raise Incomplete(f"{path} ({len(data)} bytes): {fault}") from None
    if channels < wanted.channels:
        raise Incomplete(f"{path} has {channels} of {wanted.channels} channels")
    return Arrived(path, data, channels)


def _words(sizes: dict[str, int]) -> str:
    return ", ".join(f"{path} ({size} bytes)" for path, size in sorted(sizes.items()))


async def _full(folder: Folder) -> bool:
    try:
        free = await folder.free_bytes()
    except FolderFault:
        return False
    return free is not None and free < NO_ROOM
