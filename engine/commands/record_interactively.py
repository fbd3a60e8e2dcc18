"""`labrun record-program --buttons` at a terminal: a person points at each button with the mouse."""

from pathlib import Path
from typing import Any

import typer

from ..exit_status import FAILED, PROBLEMS, SUCCEEDED
from .options import say
from .screen_picture import recorded

GROUPS = {
    "main": "Bring the analyser's program to the front, next to this terminal, and leave it idle.",
    "busy": "Start a measurement if a sign appears while it runs; otherwise skip.",
    "dialog": "Open the export dialog. For a box's `.on`, tick it first; for delete_yes, press delete.",
    "error": "Cause an error message, or skip.",
}
FIELDS = ("sample_name", "folder")


def record_asked(output: Path, title: str | None) -> int:
    """Ask for every known button in turn; each is saved as soon as it is found again."""
    from ...drivers.window_program.hands import Hands
    from ...drivers.window_program.recording import KNOWN

    hands = Hands()
    if title is None:
        title = asked("Part of the title of the program's window (Enter: the whole screen)")
    done, group = 0, ""
    for name, known in KNOWN.items():
        if known.where != group:
            group = known.where
            typer.echo(f"\n{GROUPS[group]}")
        answer = asked(
            f"{name}, {known.words}: mouse on its upper left corner, then Enter (s: skip, q: end)"
        )
        if answer == "q":
            break
        if answer != "s":
            done += _one(hands, output, name, title) == SUCCEEDED
    if not done:
        say("nothing was recorded")
        return PROBLEMS
    return _complete(output)


def point_at(output: Path, name: str, title: str, where: Any) -> bool:
    """Record one more part of the screen, pointed at by two corners; whether it was."""
    from ...drivers.window_program.hands import Hands

    hands = Hands()
    asked(f"  {name}: mouse on its upper left corner, then Enter")
    return _one(hands, output, name, title, where) == SUCCEEDED


def _one(hands: Any, output: Path, name: str, title: str, where: Any = None) -> int:
    """Record a button: two corners, for a field where to click, and the picture without the mouse."""
    from ...drivers.window_program.buttons import ButtonsFault
    from ...drivers.window_program.recording import Marked

    left, top = hands.where()
    asked("  mouse on its lower right corner, then Enter")
    right, bottom = hands.where()
    box = (min(left, right), min(top, bottom), abs(right - left), abs(bottom - top))
    at = {}
    if name in FIELDS:
        asked("  mouse into the field beside it, then Enter")
        x, y = hands.where()
        at[name] = (x - box[0] - box[2] // 2, y - box[1] - box[3] // 2)
    asked("  mouse away from it, then Enter")
    picture = hands.picture()
    ratio = hands.picture_scale(picture)
    scaled = tuple(round(n * ratio) for n in box)
    at = {n: (round(dx * ratio), round(dy * ratio)) for n, (dx, dy) in at.items()}
    try:
        return recorded(
            output, picture, Marked({name: scaled}, at, {name: where} if where else {}), title
        )  # type: ignore[dict-item]
    except ButtonsFault as fault:
        say(f"{fault}; it was not recorded")
        return FAILED


def _complete(output: Path) -> int:
    """Report whether a driver can start with what was recorded."""
    from ...drivers.window_program.buttons import ButtonsFault, read_buttons

    try:
        read_buttons(output)
    except ButtonsFault as fault:
        say(str(fault))
        return FAILED
    return SUCCEEDED


def asked(question: str) -> str:
    """A person's answer; `q` where there is nobody."""
    try:
        return input(f"{question}: ").strip()
    except EOFError:
        return "q"
