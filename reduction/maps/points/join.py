"""Say which row of a run each reduced spectrum belongs to."""

import math
import re
from collections import defaultdict
from collections.abc import Sequence
from pathlib import PurePosixPath

from .columns import Columns, number
from .rows import KEY

USUAL = "spectrum"
WORDS = re.compile(r"[^0-9A-Za-z.+-]+")


def join(columns: Columns, spectra: Sequence[str]) -> tuple[list[int], str]:
    """For each row the index of its spectrum, -1 where it has none; and how they were joined.

    spectra: paths as the tables name them. The column whose cells name most of the spectra counts,
    by file name, and by as much of the path as is needed where names repeat; else a key such as
    `3,7` is the end of a name such as `core_3_7`. The text is '' where nothing joins.
    """
    by_name = defaultdict(list)
    for index, path in enumerate(spectra):
        by_name[PurePosixPath(path).name].append(index)
        by_name[PurePosixPath(path).stem].append(index)
    best: tuple[int, bool, str, list[int]] = (0, False, "", [-1] * columns.n)
    for name, cells in columns.cells.items():
        # An area of 7 is no file 7.csv: a bare number counts in the usual column alone.
        named = [cell if name == USUAL or math.isnan(number(cell)) else "" for cell in cells]
        found = [_named(cell, by_name, spectra) for cell in named]
        n_found = len({at for at in found if at >= 0})
        best = max(best, (n_found, name == USUAL, name, found), key=lambda b: b[:2])
    if best[0]:
        return best[3], f"column {best[2]}"
    found = _by_key(columns.text(KEY), spectra)
    return found, "key at the end of the file name" if max(found, default=-1) >= 0 else ""


def _named(cell: str, by_name: dict[str, list[int]], spectra: Sequence[str]) -> int:
    parts = PurePosixPath(cell.replace("\\", "/")).parts
    if not parts or parts[-1] not in by_name:
        return -1
    alike = [_common_end(parts, PurePosixPath(spectra[at]).parts) for at in by_name[parts[-1]]]
    longest = max(alike)
    return by_name[parts[-1]][alike.index(longest)] if alike.count(longest) == 1 else -1


def _common_end(one: Sequence[str], other: Sequence[str]) -> int:
    """How many parts of two paths are the same, counted from the end; the name counts anyhow."""
    n = 0
    for a, b in zip(reversed(one), reversed(other), strict=False):
        if n and a != b:
            break
        n += 1
    return n


def _by_key(keys: Sequence[str], spectra: Sequence[str]) -> list[int]:
    """Rows by their keys, where the words of a key end the file name of exactly one spectrum."""
    ends = defaultdict(list)
    for index, path in enumerate(spectra):
        words = _words(PurePosixPath(path).stem)
        for first in range(len(words)):
            ends[words[first:]].append(index)
    found = [ends.get(_words(key), []) if key else [] for key in keys]
    return [at[0] if len(at) == 1 else -1 for at in found]


def _words(text: str) -> tuple[str, ...]:
    return tuple(word for word in WORDS.split(text) if word)
