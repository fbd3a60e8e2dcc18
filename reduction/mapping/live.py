"""Draw the element maps of a run in progress."""

import tempfile
from pathlib import Path

from .report import ROWS, make


def draw(folder: Path) -> dict[str, bytes]:
    """The figures of the complete rows so far, by file name; none if there is nothing to map.

    The same figures as in a report, from a copy without a row that is still being written. Raises
    OSError if the rows cannot be read.
    """
    with tempfile.TemporaryDirectory(prefix="labrun-live-") as place:
        copy = Path(place) / folder.resolve().name  # the figure shows the run's name
        copy.mkdir()
        for path in folder.glob(ROWS):
            rows = path.read_bytes()
            (copy / path.name).write_bytes(rows[: rows.rfind(b"\n") + 1])
        return {path.name: path.read_bytes() for path in make(copy)}
