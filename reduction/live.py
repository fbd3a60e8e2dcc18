"""Draw the element maps of a run that is still going on."""

import tempfile
from pathlib import Path

from .report import FIGURE, ROWS, make


def draw(folder: Path) -> dict[str, bytes]:
    """The figures of the rows that are whole by now, by file name; none where nothing is to map.

    What a report would draw, from a copy in which a row that is being written is left out. Raises
    OSError when the rows cannot be read.
    """
    rows = (folder / ROWS).read_bytes()
    whole = rows[: rows.rfind(b"\n") + 1]
    with tempfile.TemporaryDirectory(prefix="labrun-live-") as place:
        copy = Path(place) / folder.resolve().name  # the figure bears the run's name
        copy.mkdir()
        (copy / ROWS).write_bytes(whole)
        return {path.name: path.read_bytes() for path in make(copy) if path.name == FIGURE}
