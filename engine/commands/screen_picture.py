"""What the forms of `record-program` share: a picture of the screen, or one from a file."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from ...system.extras import missing
from ..exit_status import FAILED, NOT_REACHED, SUCCEEDED
from .options import WrongUsage, fail, failing_on, say

Image = Annotated[
    Path | None,
    typer.Option("--image", metavar="PNG", help="Use this picture instead of the screen."),
]
Title = Annotated[
    str | None,
    typer.Option("--title", help="Part of the title of the analyser's window."),
]


def picture_in(path: Path) -> Any:
    """The picture in a file, rows x columns x 3; raises WrongUsage."""
    import numpy as np
    from PIL import Image as Images

    try:
        with Images.open(path) as image:
            return np.asarray(image.convert("RGB"))
    except (OSError, ValueError) as fault:
        raise WrongUsage(f"--image {path}: it cannot be read as a picture: {fault}") from fault


def view_of_image(path: Path) -> Any:
    """A view of a picture from a file, as if it were the screen."""
    from ...drivers.window_program.view import View

    return View(picture_in(path), (0, 0), 1.0, None, (), "")


def view_of_screen(title: str) -> Any:
    """The screen, cut to the window of that title; raises NoScreen or Trouble."""
    from ...drivers.window_program.desktop import open_windows
    from ...drivers.window_program.hands import Hands
    from ...drivers.window_program.view import view_of

    hands, windows = Hands(), open_windows()
    try:
        picture = hands.picture()
        return view_of(title, windows, picture, hands.picture_scale(picture))
    finally:
        windows.close()


def told_plainly(act: Callable[[], int]) -> None:
    """Run a command's work; report a fault of the screen or of its files in one line."""
    if (why := missing("gui")) is not None:
        fail(why)
    from ...drivers.window_program.buttons import ButtonsFault
    from ...drivers.window_program.hands import NotClicked
    from ...drivers.window_program.view import Trouble
    from ...drivers.window_program.windows import NoScreen

    with (
        failing_on(WrongUsage, ButtonsFault),
        failing_on(NoScreen, Trouble, NotClicked, status=NOT_REACHED),
    ):
        raise typer.Exit(act())


def recorded(output: Path, picture: Any, marked: Any, title: str) -> int:
    """Cut buttons out, look for them, save those that are found; returns the exit status."""
    from ...drivers.window_program.recording import cut, found_again, save, seen_while_idle

    templates = cut(picture, marked)
    wrong = seen_while_idle(output, templates, marked)
    wrong |= found_again(picture, marked, templates)
    for name, words in wrong.items():
        say(f"{name} was not recorded, because it would not be found again: {words}")
    good = {name: template for name, template in templates.items() if name not in wrong}
    if good:
        save(output, good, marked, title, picture)
        say(
            f"{output} holds {', '.join(good)}; `labrun record-program --find -o {output}` looks for them"
        )
    return FAILED if wrong else SUCCEEDED
