"""Send a request to a live run from another shell, and show its answer."""

from pathlib import Path
from typing import Any

import typer

from ..exit_status import FAILED
from .options import by_command, fail, run_folder


def tell_run(runs: Path, name: str, **request: Any) -> None:
    """Ask the run's control endpoint; the exit status shows whether it complied."""
    from ..control.server import NotLive, Silent, ask_run

    try:
        by = by_command(str(request["verb"]))
        ok, text = ask_run(run_folder(runs, name), {"by": by, **request})
    except NotLive as fault:
        fail(
            str(fault) if isinstance(fault, Silent) else f"{fault}; `labrun resume` continues it",
            FAILED,
        )
    if not ok:
        fail(text)
    typer.echo(text)
