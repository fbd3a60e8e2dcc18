"""A run's report: a page for people and a crate for machines, made from the run's folder alone."""

from pathlib import Path

from ...system.files import write_whole
from .crate import crate_text
from .files import CRATE, PAGE
from .page import page
from .report_data import gather


def make(folder: Path) -> list[Path]:
    """Write `report.html`, then `ro-crate-metadata.json`, which also holds the page's hash.

    Both can be remade at any time from the run's folder; nothing else is changed.
    """
    data = gather(folder)
    _write(folder / PAGE, page(data))
    _write(folder / CRATE, crate_text(data))  # it holds the hash of the page
    return [folder / PAGE, folder / CRATE]


def _write(path: Path, text: str) -> None:
    # A character that UTF-8 cannot encode (from a file name that is not UTF-8) becomes a "?".
    write_whole(path, text.encode(errors="replace"), sync=False)
