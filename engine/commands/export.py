"""`labrun export RUN --to FORMAT`: a run as a file of another program's format."""

from pathlib import Path
from typing import Annotated

import typer

from ..exit_status import FAILED
from .options import RUNS, Runs, fail, failing_on, run_folder, say
from .resume import RunName

To = Annotated[
    str, typer.Option("--to", metavar="FORMAT", help="mcap, nexus, tiff, or a format of a plug-in.")
]
Out = Annotated[
    Path | None,
    typer.Option("--out", "-o", help="The file; by default RUN.FORMAT in this folder."),
]


def export(run: RunName, to: To, out: Out = None, runs: Runs = RUNS) -> None:
    """Write a run as a file of another format; the run's folder stays as it is."""
    from ..export.formats import SUFFIXES, ExportFault, formats
    from ..journal.journal import JournalFault, read_through
    from ..language.suggest import did_you_mean, listed
    from ..run.folder import JOURNAL, FolderFault

    known = formats()
    if to not in known:
        fail(f"--to: there is no format {to}{did_you_mean(to, known)}; there is {listed(known)}")
    try:
        folder = run_folder(runs, run)
        place = out if out is not None else Path(f"{folder.name}.{SUFFIXES.get(to, to)}")
        with failing_on(FolderFault, JournalFault, ExportFault):
            journal = read_through(folder / JOURNAL)
            torn = journal.behind  # now: a live run goes on
            if not journal.number:
                fail(
                    f"the journal of {folder.name} has no whole record: there is nothing to export"
                )
            known[to]()(folder, place)
    except OSError as fault:
        fail(f"{out or fault.filename or to} cannot be written: {fault.strerror}", FAILED)
    if torn:
        whole = f"exported are the {journal.number} records before"
        say(f"the journal's end is incomplete ({torn} bytes); {whole}")
    typer.echo(f"made {place} ({place.stat().st_size / 1e6:.1f} MB)")
