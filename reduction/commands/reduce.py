"""`labrun reduce FILE_OR_DIR...`: spectra in, tables of peaks, elements and plasmas out."""

from pathlib import Path
from typing import Annotated

import typer

from .words import Calibrated, Closure, KnownResponse, OwnLines

Given = Annotated[
    list[Path],
    typer.Argument(
        help="Spectra, folders of spectra, or a run, also by its name or `last`.",
        metavar="FILE_OR_DIR...",
        show_default=False,
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(
        "-o", "--out", help="Folder for the tables.", show_default="`reduced` beside the input"
    ),
]
Elements = Annotated[
    str | None,
    typer.Option(help="Such as Li,K,Si. Fainter lines count for these; only they get a row."),
]
Medium = Annotated[
    str | None,
    typer.Option(help="Wavelengths in air or vacuum.", show_default="decided by the lines"),
]
Unit = Annotated[
    str | None,
    typer.Option(
        help="Unit of the axis: nm, angstrom, pm, um, m, cm-1 or eV.",
        show_default="as the file says, or nm",
    ),
]
Columns = Annotated[
    str | None,
    typer.Option(
        help="Which columns to read, where none fits: wavelengths, then counts (several are "
        "shots), by number or heading, such as 1,3 or Wave,Scope; of HDF5 two paths.",
        metavar="X,Y...", show_default="by their headings",
    ),
]  # fmt: skip
Jobs = Annotated[
    int | None, typer.Option(help="Number of processes.", show_default="all cores", metavar="N")
]
Dask = Annotated[
    str | None,
    typer.Option(help="Use a dask scheduler instead: tcp://10.0.0.7:8786.", metavar="ADDRESS"),
]
Watching = Annotated[bool, typer.Option("--watch", help="Keep reducing new files until Ctrl-C.")]
UntilIdle = Annotated[
    float | None,
    typer.Option(help="With --watch: end after this long without a new file.", metavar="SECONDS"),
]
Figures = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw an overview figure.")]


def reduce(
    files: Given,
    out: Out = None,
    elements: Elements = None,
    medium: Medium = None,
    unit: Unit = None,
    columns: Columns = None,
    lines: OwnLines = None,
    response: KnownResponse = None,
    calibration: Calibrated = None,
    closure: Closure = None,
    jobs: Jobs = None,
    dask: Dask = None,
    watch: Watching = False,
    until_idle: UntilIdle = None,
    figures: Figures = True,
) -> None:
    """Reduce spectra to peaks, elements and temperatures, as CSV and Parquet, with a summary.

        Files in a folder that are not spectra are ignored; a bad spectrum is listed in `files.csv`
    with the reason.
    """
    from .reducing import Asked, reduce_asked
    from .run_name import or_run

    asked = Asked(
        [or_run(path) for path in files], out, elements, medium, unit, columns, lines, response,
        calibration, closure, jobs, dask, watch, until_idle, figures,
    )  # fmt: skip
    raise typer.Exit(reduce_asked(asked))
