"""`labrun fmt FILE...`: format protocols; their comments, quotes and order stay."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import FAILED, PROBLEMS
from ..layout.file import STDIN, Formatted, formatted, replace_text
from ..problems.print import print_problems
from .options import say

Files = Annotated[
    list[Path],
    typer.Argument(
        help="The files; `-` reads stdin and writes stdout.", metavar="FILE...", show_default=False
    ),
]
Check = Annotated[
    bool, typer.Option("--check", help="Write nothing; status 1 if a file would change.")
]
Diff = Annotated[bool, typer.Option("--diff", help="Write nothing; show what would change.")]


def fmt(files: Files, check: Check = False, diff: Diff = False) -> None:
    """Indent protocols by two spaces per level; their meaning does not change."""
    uneven, problems = 0, []
    for file in files:
        done = formatted(file)
        problems += done.problems
        uneven += done.changed
        if diff:
            _put(done.diff())
        elif check and done.changed:
            say(f"{done.name} would be reformatted")
        if not (check or diff or done.problems):
            problems += _write(file, done)
    if problems:
        print_problems(problems, file=sys.stderr)
        raise typer.Exit(PROBLEMS)
    if check and uneven:
        raise typer.Exit(FAILED)


def _write(file: Path, done: Formatted) -> list:
    """Write what changed; stdin is always written out, so that an editor gets its text back."""
    if file == STDIN:
        _put(done.after)
        return []
    problem = replace_text(file, done.after) if done.changed else None
    return [] if problem is None else [problem]


def _put(text: str) -> None:
    """Write text unchanged: `print` would change line endings on some systems."""
    sys.stdout.flush()
    sys.stdout.buffer.write(text.encode())
    sys.stdout.buffer.flush()
