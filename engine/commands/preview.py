"""`labrun preview FILE`: the points of a protocol over the work area, as a picture."""

from pathlib import Path
from typing import Annotated

import typer

from ..check import Checked
from ..views.english import count_of
from ..views.forecast import outlook
from ..views.preview.walk import Path as Way
from ..views.preview.walk import Walk
from .checked_protocol import checked_file
from .options import Bind, File, Lab, Params, fail, say

FORMATS = (".png", ".svg", ".pdf")
Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", help="The picture: .png, .svg or .pdf.", show_default=False),
]


def preview(
    file: File, output: Output = None, lab: Lab = None, bind: Bind = None, param: Params = None
) -> None:
    """Draw the points that a protocol moves to, over the area that the device may reach."""
    picture = output or Path(f"{file.stem}-preview.png")
    if picture.suffix.lower() not in FORMATS:
        fail(f"-o {picture}: the picture must be a .png, .svg or .pdf")
    checked = checked_file(file, lab, bind, param, needed=False, as_far_as_understood=True)
    walk = Walk().follow(outlook(checked))
    if not any(path.points for path in walk.paths.values()):
        fail(_nothing(checked, walk))
    from ..views.preview.figure import draw

    try:
        draw(walk, checked.protocol.name if checked.protocol is not None else "", picture)
    except OSError as fault:
        fail(f"{picture} cannot be written: {fault.strerror or fault}")
    for path in walk.paths.values():
        if path.outside:
            say(outside_text(path))
    print(picture)


def _nothing(checked: Checked, walk: Walk) -> str:
    if not walk.paths:
        return "no device of this protocol moves in a plane: none has an action with an x and a y"
    device, path = next(iter(walk.paths.items()))
    if path.unknown:
        return f"no point is known before the run: the run decides where {device} goes"
    return f"no step moves {device} to an x and a y"


def outside_text(path: Way) -> str:
    """`gantry: 3 of 1,071 points are outside x 0..4 mm, y 0..10 mm; the first is number 1,069 ...`."""
    outside = path.outside
    first = path.points[outside[0]]
    verb = "is" if len(outside) == 1 else "are"
    return (
        f"{path.plane.device}: {len(outside):,} of {count_of(len(path.points), 'point')} {verb} "
        f"outside {path.plane.area}; the first is number {outside[0] + 1:,}, "
        f"({first.x_mm:g}, {first.y_mm:g}) mm"
    )
