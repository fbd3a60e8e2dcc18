"""`labrun record-buttons`: mark the analyser program's buttons, so that the driver finds them.

At a terminal it asks for the corners of each button by the mouse; `--box` marks them for a script.
"""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from ..exit_status import FAILED, SUCCEEDED
from .on_screen import Image, Title, picture_in, told_plainly
from .options import WrongUsage, pairs, say

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
    typer.Option("--where", metavar="NAME=PLACE", help="main, dialog, error or busy."),
]
PLACES = ("main", "dialog", "error", "busy")
DEFAULT = Path("buttons")


def record_buttons(
    output: Output = DEFAULT, box: Boxes = None, at: At = None, where: Where = None,
    image: Image = None, title: Title = None,
) -> None:  # fmt: skip
    """Record buttons as pictures, and see at once that each is found again exactly once."""
    told_plainly(lambda: _record(output, box, at, where, image, title))


def _record(
    output: Path, box: list[str] | None, at: list[str] | None, where: list[str] | None,
    image: Path | None, title: str | None,
) -> int:  # fmt: skip
    from ...drivers.sciaps_gui.recording import Marked

    if not box:
        if image is not None or not sys.stdin.isatty():
            raise WrongUsage("mark buttons with --box NAME=X,Y,W,H, or run it at a terminal")
        from .record_asked import record_asked

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


def recorded(output: Path, picture: Any, marked: Any, title: str) -> int:
    """Cut, look again, save what was found again; the exit status."""
    from ...drivers.sciaps_gui.recording import cut, found_again, save

    templates = cut(picture, marked)
    wrong = found_again(picture, marked, templates)
    for name, words in wrong.items():
        say(f"{name} was not recorded: it would not be found again: {words}")
    good = {name: template for name, template in templates.items() if name not in wrong}
    if good:
        save(output, good, marked, title, picture)
        say(f"{output} holds {', '.join(good)}; `labrun find-buttons {output}` looks for them")
    return FAILED if wrong else SUCCEEDED


def _screen() -> Any:
    from ...drivers.sciaps_gui.hands import Hands

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
            raise WrongUsage(f"--where {name}={place}: it is one of {', '.join(PLACES)}")
    return places


def _check_names(marked: Any) -> None:
    from ...drivers.sciaps_gui.recording import KNOWN, place_of
    from ..language.suggest import did_you_mean

    for name in marked.boxes:
        if place_of(name, marked) is None:
            raise WrongUsage(
                f"--box {name}: the driver knows no such button (for one of your own steps say where it "
                f"is to be seen: --where {name}=dialog){did_you_mean(name, KNOWN)}"
            )
