"""`labrun record-program --find`: which recorded buttons are visible now, where, how well."""

from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import FAILED, SUCCEEDED
from .options import WrongUsage, say
from .screen_picture import Image, Title, told_plainly, view_of_image, view_of_screen

Folder = Annotated[
    Path, typer.Argument(help="The folder that `labrun record-program` wrote.", metavar="FOLDER")
]
Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="PNG", help="Write a picture with a box around each."),
]


def find_buttons(
    folder: Folder, image: Image = None, title: Title = None, output: Output = None
) -> None:
    """`labrun record-program --find`, by its earlier name."""

    def act() -> int:
        say(
            "it is `labrun record-program --find -o FOLDER` now; this name goes with the next release"
        )
        return find(folder, image, title, output)

    told_plainly(act)


def find(folder: Path, image: Path | None, title: str | None, output: Path | None) -> int:
    """Look for the recorded buttons; status 1 unless each of the main window is there once."""
    from ...drivers.window_program.buttons import read_buttons
    from ...drivers.window_program.desktop import open_controls
    from ...drivers.window_program.recording import drawn, looked

    recorded = read_buttons(folder, needed=())
    wanted = recorded.title if title is None else title
    view = view_of_image(image) if image is not None else view_of_screen(wanted)
    controls = open_controls() if recorded.by_name and image is None else None
    sights = looked(recorded, view, controls)
    for name, sight in sights.items():
        where = recorded.button(name.removesuffix(".on")).where
        typer.echo(f"{'ok ' if sight.sure else '-- '} {where:<6} {sight.words()}")
    if recorded.by_name and controls is None:
        say("what is known by a control's name cannot be looked for in a picture")
    if view.cover:
        say(view.cover)
    main = recorded.named("main")
    if output is not None:
        shown = {name: sight for name, sight in sights.items() if sight.hits or name in main}
        _write(output, drawn(view, shown))
    sure = all(name in sights and sights[name].sure for name in main)
    return SUCCEEDED if sure else FAILED


def _write(path: Path, picture) -> None:
    from PIL import Image as Images

    try:
        Images.fromarray(picture).save(path)
    except (OSError, ValueError) as fault:
        raise WrongUsage(f"-o {path}: the picture cannot be written: {fault}") from fault
    say(f"{path} shows what was found where")
