"""Wait until the files that an export writes are complete.

"Success" is reported while the CSV is still being written (55 of 365 kB, measured), so files are
accepted when no size has changed for a while, every line is readable and no channel is missing.
"""

import asyncio
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fnmatch import fnmatch
from hashlib import sha256

from .folder import Folder, FolderFault
from .spectrum_csv import Incomplete, NoSpectrum, judged

LOOK_S = 0.25
NO_ROOM = 1_000_000
"""Bytes: with less than that free, an export that stays incomplete is reported as a full disk."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to wait for: a new file whose name matches `pattern`, with at least `channels` channels.

    `before` is what was in the folder when the export was requested. `ours` says of a new name
    whether this export made it, by what was typed or by its time: anything else is a stranger's.
    `breaks_off`: the export may be broken off anywhere, so a last line needs its end or the count.
    """

    before: frozenset[str]
    pattern: str
    channels: int = 0
    ours: Callable[[str], bool] = lambda name: True
    settle_s: float = 1.0
    breaks_off: bool = False


@dataclass(frozen=True, slots=True)
class Arrived:
    """A complete spectrum: where it was found, its bytes, its channels, SHA-256 of its numbers."""

    path: str
    data: bytes
    channels: int
    numbers: str
    fits: bool

    @property
    def keys(self) -> tuple[str, str]:
        """By what it is known again: the file as it is, and its numbers alone."""
        return sha256(self.data).hexdigest(), self.numbers


class NotArrived(Exception):
    """No complete file arrived; the text says what is there. `full` if its disk is full."""

    def __init__(self, text: str, full: bool = False) -> None:
        super().__init__(text)
        self.full = full


def has_name(path: str, typed: Iterable[str]) -> bool:
    """Whether a file or folder bears one of these names, whatever became of its punctuation."""
    return any(_letters(name) in _letters(path) for name in typed)


def _letters(text: str) -> str:
    return "".join(c for c in text.casefold() if c.isalnum())


async def arrived(folder: Folder, wanted: Wanted, timeout_s: float) -> list[Arrived]:
    """All spectra of one export, as soon as they are complete; raises NotArrived."""
    loop = asyncio.get_running_loop()
    end = loop.time() + timeout_s
    seen: dict[str, int] = {}
    still_since = loop.time()
    while True:
        why = "there is nothing new"
        try:
            ours, strangers = await _new_names(folder, wanted)
            if strangers:
                why += f" of this export ({', '.join(strangers)} came meanwhile, and is not of it)"
            sizes = await _sizes(folder, ours)
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


async def _new_names(folder: Folder, wanted: Wanted) -> tuple[list[str], list[str]]:
    """What is new: of this export, and of strangers."""
    new = sorted(await folder.names() - wanted.before)
    ours = [name for name in new if wanted.ours(name)]
    return ours, [name for name in new if name not in ours]


async def _sizes(folder: Folder, names: list[str]) -> dict[str, int]:
    sizes: dict[str, int] = {}
    for name in names:
        sizes |= await folder.files(name)
    return sizes


async def _whole(folder: Folder, wanted: Wanted, sizes: dict[str, int]) -> list[Arrived]:
    """Every spectrum among these files, read in full; raises Incomplete if one is cut off."""
    suffix = wanted.pattern.rpartition(".")[2]
    found, faults = [], []
    for path in sorted(path for path in sizes if fnmatch(path, f"*.{suffix}")):
        try:
            found.append(await _one(folder, wanted, path, sizes[path]))
        except NoSpectrum as fault:
            faults.append(str(fault))
    if not found:
        raise Incomplete("; ".join(faults) or f"{_words(sizes)}; none is called {wanted.pattern}")
    return found


async def _one(folder: Folder, wanted: Wanted, path: str, size: int) -> Arrived:
    data = await folder.read(path)
    if len(data) != size:
        raise Incomplete(f"{path} is still growing")
    fits = fnmatch(path.rpartition("/")[2], wanted.pattern)
    try:
        spectrum = judged(data)
    except Incomplete as fault:
        kind = NoSpectrum if isinstance(fault, NoSpectrum) and not fits else Incomplete
        raise kind(f"{path} ({len(data)} bytes): {fault}") from None
    if spectrum.channels < wanted.channels:
        raise Incomplete(f"{path} has {spectrum.channels} of {wanted.channels} channels")
    if wanted.breaks_off and not spectrum.ended and not wanted.channels:
        raise Incomplete(
            f"{path} ends without a line end after {spectrum.channels} channels, so it may be cut off; if "
            f"that is all, write `channels: {spectrum.channels}`"
        )
    return Arrived(path, data, spectrum.channels, spectrum.numbers, fits)


def _words(sizes: dict[str, int]) -> str:
    return ", ".join(f"{path} ({size} bytes)" for path, size in sorted(sizes.items()))


async def _full(folder: Folder) -> bool:
    try:
        free = await folder.free_bytes()
    except FolderFault:
        return False
    return free is not None and free < NO_ROOM
