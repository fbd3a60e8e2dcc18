"""`labrun record-program --buttons`: mark the analyser program's buttons, so that the driver finds them.

At a terminal, the corners of each button are set with the mouse; `--box` is for scripts.
"""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from .options import WrongUsage, pairs, say
from .screen_picture import Image, Title, picture_in, recorded, told_plainly

Output = Annotated[
    Path, typer.Option("-o", "--output", metavar="FOLDER", help="The folder to record into.")
]
Boxes = Annotated[
    list[str] | None,
    typer.Option("--box", metavar="NAME=X,Y,W,H", help="A button's place, in pixels."),
]
At = Annotated[
    list[str] | None,
    typer.Option("--at", metavar="NAME=DX,DY", help="Where to click, from the middle of its box."),
]
Where = Annotated[
    list[str] | None,
    typer.Option("--where", metavar="NAME=PLACE", help="main, dialog, error, banner or busy."),
]
PLACES = ("main", "dialog", "error", "banner", "busy")
DEFAULT = Path("buttons")


def record_buttons(
    output: Output = DEFAULT, box: Boxes = None, at: At = None, where: Where = None,
    image: Image = None, title: Title = None,
) -> None:  # fmt: skip
    """`labrun record-program --buttons`, by its earlier name."""

    def act() -> int:
        say("it is `labrun record-program --buttons` now; this name goes with the next release")
        return record(output, box, at, where, image, title)

    told_plainly(act)


def record(
    output: Path, box: list[str] | None, at: list[str] | None, where: list[str] | None,
    image: Path | None, title: str | None,
) -> int:  # fmt: skip
    """Record buttons as pictures, and check at once that each is found exactly once."""
    from ...drivers.window_program.recording import Marked

    if not box:
        if image is not None or not sys.stdin.isatty():
            raise WrongUsage("mark buttons with --box NAME=X,Y,W,H, or run it at a terminal")
        from .record_interactively import record_asked

        return record_asked(output, title)
    marked = Marked(
        boxes={
            name: _numbers("--box", name, text, 4) for name, text in pairs(box, "--box").items()
        },
        at={name: _numbers("--at", name, text, 2) for name, text in pairs(at, "--at").items()},
        where=_places(where),
    )
    _check_names(marked)
    picture = picture_in(image) if image is not None else _screen()
    return recorded(output, picture, marked, title or "")


def _screen() -> Any:
    from ...drivers.window_program.hands import Hands

    return Hands().picture()


def _numbers(option: str, name: str, text: str, count: int) -> Any:
    try:
        numbers = tuple(int(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != count:
        shape = "X,Y,W,H" if count == 4 else "DX,DY"
        raise WrongUsage(f"{option} {name}={text}: write {count} whole numbers, {name}={shape}")
    return numbers


def _places(where: list[str] | None) -> Any:
    places = pairs(where, "--where")
    for name, place in places.items():
        if place not in PLACES:
            raise WrongUsage(f"--where {name}={place}: choose one of {', '.join(PLACES)}")
    return places


def _check_names(marked: Any) -> None:
    from ...drivers.window_program.recording import KNOWN, place_of
    from ..language.suggest import did_you_mean

    for name in marked.boxes:
        if place_of(name, marked) is None:
            raise WrongUsage(
                f"--box {name}: the driver knows no such button (for a step of your own, state where it "
                f"appears: --where {name}=dialog){did_you_mean(name, KNOWN)}"
            )
