"""Send a request to a live run from another shell, and show its answer."""

from pathlib import Path
from typing import Any

import typer

from ..exit_status import FAILED, PROBLEMS
from .options import by_command, say


def tell_run(runs: Path, name: str, **request: Any) -> None:
    """Ask the run's control endpoint; the exit status shows whether it complied."""
    from ..control.server import NotLive, Silent, ask_run
    from ..run.folder import FolderFault, find_run

    try:
        by = by_command(str(request["verb"]))
        ok, text = ask_run(find_run(runs, name), {"by": by, **request})
    except FolderFault as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None
    except NotLive as fault:
        say(str(fault) if isinstance(fault, Silent) else f"{fault}; `labrun resume` continues it")
        raise typer.Exit(FAILED) from None
    if not ok:
        say(text)
        raise typer.Exit(PROBLEMS)
    typer.echo(text)
