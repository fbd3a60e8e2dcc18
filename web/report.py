"""A run's report: a page for people and a crate for machines, made from the run's folder alone."""

from pathlib import Path

from .crate import crate_text
from .files import CRATE, PAGE, write_whole
from .material import gather
from .page import page


def make(folder: Path) -> list[Path]:
    """Write `report.html`, then `ro-crate-metadata.json`, which holds the page's hash, too.

    Both are made again at any time from what lies in the folder; neither touches anything else.
    """
    material = gather(folder)
    write_whole(folder / PAGE, page(material))
    write_whole(folder / CRATE, crate_text(material))
    return [folder / PAGE, folder / CRATE]
