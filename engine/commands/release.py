"""`labrun release FILE`: let a program, such as an agent behind `labrun mcp`, start this once."""

import secrets
import shutil
import sys
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path

import typer

from ...system.files import write_whole
from ..check import Checked
from ..exit_status import FAILED
from ..run.released import FOLDER, RECORD, Release, lab_digest
from .checked_protocol import checked_file
from .options import RUNS, Bind, File, Lab, Params, Runs, fail, pairs

YES = "release"


def release(
    file: File, param: Params = None, lab: Lab = None, bind: Bind = None, runs: Runs = RUNS
) -> None:
    """Release a protocol with these parameters: a program may then start it, once, as it is now."""
    from ...system.process import user_name

    checked = checked_file(file, lab, bind, param)
    given = pairs(param, "-p")
    if not at_a_terminal():
        fail("a release is a person's word: give this command in a terminal")
    try:
        folder = copied(checked, runs, given)
    except OSError as fault:
        fail(f"it cannot be released: {fault.strerror or fault}: {fault.filename or runs}", FAILED)
    released = False
    try:
        # What is read is what was copied: a file may be changed while a person reads.
        copy = checked_file(next(folder.glob("protocol.*")), lab, bind, param)
        _show(copy, given)
        released = typer.prompt(f"Type `{YES}` if a program may start this once") == YES
        if released:
            record = record_of(folder, copy, file, given, user_name())
            write_whole(folder / RECORD, record.model_dump_json(indent=1).encode())
    finally:
        if not released:
            shutil.rmtree(folder, ignore_errors=True)
    if not released:
        fail("not released")
    typer.echo(f"released as {folder.name}; to take it back, delete {folder}")


def at_a_terminal() -> bool:
    """Whether a person can read and type here."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def _show(checked: Checked, given: dict[str, str]) -> None:
    """What will be done, in words, with which values and devices."""
    from ...schemas.quantity import is_quantity, quantity_text
    from ..views.words.page import as_text, page

    for line in as_text(page(checked)):
        typer.echo(line)
    typer.echo("")
    for name, value in checked.params.items():
        text = quantity_text(value) if is_quantity(value) else value
        typer.echo(f"  {name} = {given.get(name, text)}")
    for name, role in checked.roles.items():
        typer.echo(f"  {name}: {role.device}")


def copied(checked: Checked, runs: Path, given: dict[str, str]) -> Path:
    """A new folder with all that the run would use; no release yet. Raises OSError."""
    from ..runner.begin import keep

    folder = runs / FOLDER / secrets.token_hex(4)
    folder.mkdir(parents=True)
    try:
        keep(folder, checked, given)
    except BaseException:  # Ctrl-C as well
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return folder


def record_of(
    folder: Path, checked: Checked, file: Path, given: dict[str, str], by: str = ""
) -> Release:
    """The record that makes a release of what was copied into a folder."""
    assert checked.source is not None and checked.protocol is not None and checked.lab is not None
    return Release(
        id=folder.name, file=file.name, protocol=checked.protocol.name,
        sha256=sha256(checked.source.text.encode()).hexdigest(), lab=lab_digest(checked.lab),
        params=given, roles={name: role.device for name, role in checked.roles.items()},
        by=by, at=datetime.now(UTC).isoformat(timespec="seconds"),
    )  # fmt: skip
