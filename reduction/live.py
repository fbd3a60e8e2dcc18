"""Draw the element maps of a run that is still going on."""

import tempfile
from pathlib import Path

from .report import make

ROWS = "data*.csv"


def draw(folder: Path) -> dict[str, bytes]:
    """The figures of the rows that are whole by now, by file name; none where nothing is to map.

    What a report would draw, from a copy in which a row that is being written is left out. Raises
    OSError when the rows cannot be read.
    """
    with tempfile.TemporaryDirectory(prefix="labrun-live-") as place:
        copy = Path(place) / folder.resolve().name  # the figure bears the run's name
        copy.mkdir()
        for path in folder.glob(ROWS):
            rows = path.read_bytes()
            (copy / path.name).write_bytes(rows[: rows.rfind(b"\n") + 1])
        return {path.name: path.read_bytes() for path in make(copy)}
