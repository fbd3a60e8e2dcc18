"""`labrun spectrum FILE`: the results of one spectrum, as text and figures."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .words import (
    FAILED,
    PROBLEMS,
    Closure,
    KnownResponse,
    OwnLines,
    known_response,
    own_lines,
    say,
    symbols,
)  # fmt: skip
from .words import closure as closure_of
from .words import columns as columns_of

if TYPE_CHECKING:
    from ..lines.formula import Closed
    from ..reduce import Reduction


def spectrum(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Text, a spreadsheet, or a spectrometer's file.")
    ],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Output folder; FILE's folder by default.")
    ] = None,
    elements: Annotated[
        str | None, typer.Option(help="Elements to report the predominant peak of.")
    ] = None,
    window: Annotated[
        str | None,
        typer.Option(metavar="FROM:TO", help="Range of the fit figure in nm, such as 668:674."),
    ] = None,
    log: Annotated[bool, typer.Option("--log", help="Logarithmic axis for the counts.")] = False,
    unit: Annotated[
        str | None,
        typer.Option(
            help="Unit of the axis: nm, angstrom, pm, um, m, cm-1, eV; nm if FILE says none."
        ),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y...", help="Columns to read, such as 1,3; by headings if not given."
        ),
    ] = None,
    lines: OwnLines = None,
    response: KnownResponse = None,
    closure: Closure = None,
    format: Annotated[str, typer.Option(help="Figure format: png, svg or pdf.")] = "png",
) -> None:
    """Draw a spectrum with labelled lines, its fit, and the plots of its plasma."""
    from ..figures.paper import FORMATS

    if format not in FORMATS:
        say(f"--format {format}: choose one of {', '.join(FORMATS)}")
        raise typer.Exit(PROBLEMS)
    try:
        own_lines(lines)
        divided = known_response(response)
        closed = closure_of(closure)
        stretch = None if window is None else _stretch(window)
        reduction, written = _draw(
            file, out, elements, stretch, log, (unit, columns, divided), format
        )
    except ValueError as fault:
        say(f"{file}: {fault}")
        raise typer.Exit(PROBLEMS) from None
    except OSError as fault:
        unread = fault.filename in (None, str(file))
        say(f"{fault.filename or file}: {fault.strerror or fault}")
        raise typer.Exit(PROBLEMS if unread else FAILED) from None
    _print(reduction)
    if closed is not None:
        _print_contents(reduction, closed)
    for path in written:
        typer.echo(f"wrote {path}")


def _draw(file: Path, out: Path | None, elements, stretch, log: bool, how, format):
    from ..figures.spectrum_figures import draw_spectrum
    from ..reduce import reduce_spectrum
    from ..spectrum.read import read_spectrum
    from ..spectrum.response import read_response

    found = read_spectrum(file, how[0], columns_of(how[1]))
    if how[2] is not None:
        found = read_response(how[2]).divided_out(found)
    reduction = reduce_spectrum(found, symbols(elements, "--elements"))
    folder = file.parent if out is None else out
    folder.mkdir(parents=True, exist_ok=True)
    return reduction, draw_spectrum(found, reduction, folder, file.stem, stretch, log, format)


def _stretch(text: str) -> tuple[float, float]:
    first, _, last = text.partition(":")
    try:
        low, high = float(first), float(last)
    except ValueError:
        raise ValueError(f"--window {text}: write it as FROM:TO in nm, such as 668:674") from None
    if not low < high:
        raise ValueError(f"--window {text}: the first wavelength must be smaller")
    return low, high


def _print(reduction: "Reduction") -> None:
    from ..tables.plot import cation_fraction

    typer.echo(f"{reduction.n_peaks} peaks, wavelengths in {reduction.medium}")
    for note in reduction.notes:
        typer.echo(f"note: {note}")
    typer.echo(f"detected: {', '.join(reduction.detected) or 'no element'}")
    for element, peak in reduction.elements.items():
        said = f"{peak.area:.5g} ± {peak.area_error:.2g} counts nm" if peak.area else f"{peak.fate}"
        typer.echo(f"{element:>4} {said}")
    plasma, share = reduction.plasma, cation_fraction(reduction)
    if plasma is None:
        typer.echo("the plasma temperature cannot be determined")
        return
    if plasma.temperature_k is not None:
        error = plasma.temperature_error_k or 0.0
        typer.echo(f"T = {plasma.temperature_k:,.0f} ± {error:,.0f} K ({plasma.method})")
    if plasma.log10_ne is not None:
        typer.echo(f"log10 ne = {plasma.log10_ne:.2f} ± {plasma.log10_ne_error or 0.0:.2f} per cm3")
    if share is not None:
        typer.echo(
            f"Li cation fraction {share.share:.3f} ± {share.share_error:.3f} "
            f"(atoms, of {', '.join(share.elements)})"
        )
    for flag in plasma.flags:
        typer.echo(flag)


def _print_contents(reduction: "Reduction", closed: "Closed") -> None:
    from ..calibration.closure import concentrations

    said = concentrations(reduction, closed)
    if not said:
        typer.echo("no concentrations: the lines do not tell the plasma's amounts")
    told = [(name, one) for name, one in said.items() if one.wt_percent is not None]
    for name, one in sorted(told, key=lambda pair: -(pair[1].wt_percent or 0.0)):
        flags = f"  {'; '.join(one.flags)}" if one.flags else ""
        typer.echo(
            f"{name:>4} {one.wt_percent:.4g} ± {one.error:.2g} wt % "
            f"({one.low:.3g} to {one.high:.3g}){flags}"
        )
