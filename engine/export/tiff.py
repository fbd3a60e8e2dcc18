"""A run's map as a TIFF stack, which Fiji and ImageJ open: a page a column; name, unit, scale and origin."""

from io import BytesIO
from pathlib import Path

import numpy as np
import tifffile

from ...system.files import replace_whole
from ..journal.journal import JournalFault
from ..run.folder import FolderFault
from .formats import ExportFault
from .tables import AXES, grid_of, numbers_of, tables

NEAR_0 = 1e-9
EVEN = 0.01
"""Of the step, that the steps of a grid may differ by and be one to an image."""


def write(folder: Path, place: Path) -> None:
    """Write the first map of the run in `folder` to `place`; raises ExportFault and OSError.

    Pages are (y, x), the highest y on top as in every map of a run; NaN where nothing was measured.
    """
    try:
        pages, labels, even, unit = _map(folder)
    except (JournalFault, FolderFault) as fault:
        raise ExportFault(str(fault)) from fault
    described = {"axes": "CYX", "Labels": labels, "unit": "micron" if unit == "µm" else unit}
    scale = None
    if even is not None:
        (y, step_y), (x, step_x) = even
        scale = (1.0 / step_x, 1.0 / step_y)
        # As ImageJ has it: the pixel at 0. An origin of exactly 0 it takes for one that nobody gave.
        top = pages.shape[1] - 1 + y / step_y
        described |= {"xorigin": -x / step_x, "yorigin": top or NEAR_0, "inverty": True}
    made = BytesIO()
    tifffile.imwrite(made, pages[:, ::-1], imagej=True, resolution=scale, metadata=described)
    with replace_whole(place) as out:
        out.write(made.getvalue())


def _map(folder: Path) -> tuple[np.ndarray, list[str], list[tuple[float, float]] | None, str]:
    """Pages (columns, y, x), a label each, first place and step of y and x (None: uneven), their unit."""
    for rows in (list(table.values()) for table in tables(folder).values()):
        columns = list(dict.fromkeys(column for _, row in rows for column in row))
        numbers = {c: made for c in columns if (made := numbers_of([r.get(c) for _, r in rows]))}
        if not set(AXES) < set(numbers):
            continue
        grid = grid_of([numbers[axis][0] for axis in AXES])
        if grid is None or min(len(values) for values, _ in grid) < 2:
            continue
        (y, at_y), (x, at_x) = grid
        named = [column for column in columns if column in numbers and column not in AXES]
        pages = np.full((len(named), len(y), len(x)), np.nan, dtype=np.float32)
        for page, column in zip(pages, named, strict=True):
            page[at_y, at_x] = numbers[column][0]
        units = [numbers[axis][1] for axis in AXES]
        even = units[0] == units[1] and all(_even(np.diff(values)) for values in (y, x))
        along = [(float(at[0]), float(np.mean(np.diff(at)))) for at in (y, x)] if even else None
        labels = [f"{c} ({unit})" if (unit := numbers[c][1]) else c for c in named]
        return pages, labels, along, units[0] if even else ""
    raise ExportFault(
        f"{folder.name} has no table whose columns x and y are a grid, which an image needs; "
        "--to nexus takes points as they are"
    )


def _even(steps: np.ndarray) -> bool:
    return bool(np.ptp(steps) <= EVEN * np.mean(steps))
