"""`labrun reduce FILE_OR_DIR...`: spectra in, tables of peaks, elements and plasmas out."""

from pathlib import Path
from typing import Annotated

import typer

Given = Annotated[
    list[Path],
    typer.Argument(
        help="Spectra, folders of them, or a run.", metavar="FILE_OR_DIR...", show_default=False
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("-o", "--out", help="Where the tables go.", show_default="`reduced` beside it"),
]
Elements = Annotated[
    str | None,
    typer.Option(
        help="Those wanted: Li,K,Si. Their lines count at lower noise; only they get a row."
    ),
]
Medium = Annotated[
    str | None,
    typer.Option(help="air or vacuum: of the wavelengths.", show_default="the lines decide"),
]
Unit = Annotated[str, typer.Option(help="nm, angstrom or um: of the wavelengths.")]
Jobs = Annotated[int | None, typer.Option(help="Processes.", show_default="all cores", metavar="N")]
Dask = Annotated[
    str | None,
    typer.Option(help="A dask scheduler instead: tcp://10.0.0.7:8786.", metavar="ADDRESS"),
]
Watching = Annotated[bool, typer.Option("--watch", help="Go on with what arrives, until Ctrl-C.")]
UntilIdle = Annotated[
    float | None,
    typer.Option(help="With --watch: end when nothing came for so long.", metavar="SECONDS"),
]
Figures = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw an overview.")]


def reduce(
    files: Given,
    out: Out = None,
    elements: Elements = None,
    medium: Medium = None,
    unit: Unit = "nm",
    jobs: Jobs = None,
    dask: Dask = None,
    watch: Watching = False,
    until_idle: UntilIdle = None,
    figures: Figures = True,
) -> None:
    """Reduce spectra: peaks, elements, temperatures; as CSV and Parquet, with a summary.

    Of a folder only spectra are taken; a spoiled one is a row of `files.csv` with its reason.
    """
    from .reducing import Asked, reduce_asked

    asked = Asked(files, out, elements, medium, unit, jobs, dask, watch, until_idle, figures)
    raise typer.Exit(reduce_asked(asked))
