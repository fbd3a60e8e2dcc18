"""`labrun record-program`: work a program once, and get the lab entry by which a driver does it again."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import FAILED, SUCCEEDED
from .find_buttons import find
from .options import WrongUsage, say
from .record_buttons import At, Boxes, Where, record
from .screen_picture import Image, Title, told_plainly, view_of_screen

Output = Annotated[
    Path,
    typer.Option("-o", "--output", metavar="FOLDER", help="The folder for pictures and lab.yaml."),
]
Contract = Annotated[
    str | None,
    typer.Option(
        "--contract", metavar="FILE|TYPE", help="What is to be kept: recorder.yaml, or NAME@1."
    ),
]
Watched = Annotated[
    list[Path] | None,
    typer.Option(
        "--watch", metavar="FOLDER", help="Where the program writes: a new file proves an action."
    ),
]
ByHand = Annotated[
    bool,
    typer.Option("--buttons", help="Only record the buttons of an analyser's program, one by one."),
]
Names = Annotated[
    bool,
    typer.Option("--names", help="Only note the controls that the program names (on Windows)."),
]
Find = Annotated[
    bool, typer.Option("--find", help="Only tell which recorded buttons are visible now.")
]
Seen = Annotated[
    Path | None,
    typer.Option("--seen", metavar="PNG", help="With --find: a picture with a box around each."),
]


def record_program(
    output: Output = Path("program"), contract: Contract = None, watch: Watched = None,
    title: Title = None, buttons: ByHand = False, names: Names = False, find_them: Find = False,
    box: Boxes = None, at: At = None, where: Where = None, image: Image = None, seen: Seen = None,
) -> None:  # fmt: skip
    """Write how a driver works a program that has only a window, while somebody works it."""

    def act() -> int:
        if find_them:
            return find(output, image, title, seen)
        if names:
            return _note_names(output, title)
        if buttons or box or image is not None:
            return record(output, box, at, where, image, title)
        return _work(output, contract, watch or [], title)

    told_plainly(act)


def _note_names(output: Path, title: str | None) -> int:
    """Write every control that has a name of its own into buttons.yaml, and show them."""
    if not title:
        raise WrongUsage(
            'say whose controls: --title "Profile Builder", a part of its window\'s title'
        )
    from ...drivers.window_program.desktop import open_controls
    from ...drivers.window_program.recording import named_controls, save_names

    controls = open_controls()
    entries = named_controls(view_of_screen(title), controls)
    for name, entry in entries.items():
        said = ", ".join(f"{word}: {what}" for word, what in entry["control"].items())
        typer.echo(f"{entry.get('where', 'main'):<6} {name}: {said}")
    new = save_names(output, title, entries)
    say(
        f"{output} has {len(new)} new names; `labrun record-program --find -o {output}` looks for them"
    )
    return SUCCEEDED if entries else FAILED


def _work(output: Path, contract: str | None, watch: list[Path], title: str | None) -> int:
    if contract is None:
        raise WrongUsage(
            "say what the program is to do, as a contract: --contract recorder.yaml (`labrun new device "
            "recorder` writes one), or one that ships, such as libs_analyzer@1"
        )
    if not sys.stdin.isatty():
        raise WrongUsage("it asks which action is worked: run it at a terminal")
    for folder in watch:
        if not folder.is_dir():
            raise WrongUsage(f"--watch {folder}: there is no such folder")
    from .record_worked import record_worked

    record_worked(output, contract, watch, title)
    return SUCCEEDED
