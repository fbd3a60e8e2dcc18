"""Find the spectra in the given files, folders, and run folders."""

import os
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .looks import not_a_spectrum
from .source import Source, natural, source
from .summary import MADE_BY, NAME

RUN_MARKS = ("journal.jsonl", "run.json")
SPECTRA = "spectra"
NOT_OF_A_RUN = {"servers", "used", "contracts"}
OUT_NAME = "reduced"
BEGINNING = 64  # bytes of a summary, by which ours is recognised


@dataclass(slots=True)
class Found:
    """Spectra in the order of their names; skipped files, each with its reason."""

    spectra: list[Source] = field(default_factory=list)
    left_aside: list[tuple[str, str]] = field(default_factory=list)


def is_run(folder: Path) -> bool:
    """Whether the folder is a run's."""
    return any((folder / mark).is_file() for mark in RUN_MARKS)


def is_reduced(folder: Path) -> bool:
    """Whether the folder holds the tables of an earlier reduction."""
    try:
        with (folder / NAME).open("rb") as file:
            return f'"{MADE_BY}"'.encode() in file.read(BEGINNING)
    except OSError:
        return False


def default_out(given: Sequence[Path]) -> Path:
    """`reduced` inside a run folder, or beside any other folder or file."""
    root = root_of(given)
    return (root if len(given) > 1 or is_run(root) else given[0].resolve().parent) / OUT_NAME


def root_of(given: Sequence[Path]) -> Path:
    """The folder that names in the tables are relative to: the given one, or the common parent."""
    if len(given) == 1 and given[0].is_dir():
        return given[0].resolve()
    parents = [path.resolve().parent for path in given]
    try:
        return Path(os.path.commonpath(parents))
    except ValueError:  # two drives
        return parents[0]


def gather(given: Sequence[Path], out: Path, sure: Container[Path] = ()) -> Found:
    """All spectra in the given paths, each once; `out` is not searched.

    A file given by name is taken as it is, and so are those that the caller already knows.
    Raises OSError for a folder that cannot be read.
    """
    found, seen = Found(), set()
    root, out = root_of(given), out.resolve()
    for path in given:
        named = path.resolve()
        files = _below(named, out) if named.is_dir() else [named]
        for file in files:
            one = source(file, root)
            if file in seen:
                continue
            seen.add(file)
            known = not named.is_dir() or file in sure
            reason = None if known else _why_not(file)
            if reason is None:
                found.spectra.append(one)
            else:
                found.left_aside.append((one.name, reason))
    found.spectra.sort(key=lambda one: natural(one.name))
    return found


def _why_not(file: Path) -> str | None:
    try:
        return not_a_spectrum(file)
    except OSError:
        return None  # its row will report that it cannot be opened


def _below(folder: Path, out: Path) -> Iterator[Path]:
    """Every file that may be a spectrum; in a run only files that its devices delivered."""
    run = is_run(folder)
    top = folder / SPECTRA if run and (folder / SPECTRA).is_dir() else folder
    for place, folders, files in os.walk(top, onerror=_raise):
        here = Path(place)
        folders[:] = sorted(name for name in folders if _enters(here / name, out, run))
        own = _tables() if here == out or is_reduced(here) else set()
        yield from (here / name for name in sorted(files) if name not in own)


def _enters(folder: Path, out: Path, run: bool) -> bool:
    if folder.name.startswith(".") or folder == out or is_reduced(folder):
        return False
    return not (run and folder.name in NOT_OF_A_RUN)


def _tables() -> Iterable[str]:
    from ..tables.write import file_names

    return {*file_names(), NAME}


def _raise(fault: OSError) -> None:
    raise fault
