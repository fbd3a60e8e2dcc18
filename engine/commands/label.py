"""`labrun label RUN`: say of a run what it was measured on, tag it, note something about it."""

from typing import Annotated

import typer
from pydantic import ValidationError

from ..exit_status import FAILED
from .options import RUNS, Runs, fail, run_folder
from .resume import RunName

Sample = Annotated[str | None, typer.Option("--sample", help="What it was measured on.")]
Tags = Annotated[
    list[str] | None, typer.Option("--tag", help="A word to find it by; --tag=-WORD removes it.")
]
Note = Annotated[str | None, typer.Option("--note", help="A remark; it replaces the one before.")]


def label(
    run: RunName, sample: Sample = None, tag: Tags = None, note: Note = None, runs: Runs = RUNS
) -> None:
    """Give a run a sample, tags or a note, or show them; nothing that it measured changes."""
    from ...schemas.model import first_fault
    from ..run.labels import labelled, read_labels, write_labels

    try:
        folder = run_folder(runs, run)
        made = labelled(read_labels(folder), sample=sample, tags=tag or [], note=note)
        if (sample, tag, note) != (None, None, None):
            write_labels(folder, made)
    except ValidationError as fault:
        fail(first_fault(fault))
    except OSError as fault:
        fail(f"the labels of {run} cannot be written: {fault.strerror}", FAILED)
    tags = " ".join(made.tags)
    typer.echo(
        f"{folder.name}: sample {made.sample or '-'}; tags {tags or '-'}; note {made.note or '-'}"
    )
