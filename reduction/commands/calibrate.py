"""`labrun calibrate response` and `standards`: what `labrun reduce --response` and `--calibration` read."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import typer

from .say import FAILED, PROBLEMS, say
from .words import Closure, KnownResponse, OwnLines

UNSURE = 0.5  # of the response
SAME_NM = 1e-3

calibrate = typer.Typer(
    name="calibrate", no_args_is_help=True, help="Calibrate an instrument from what is known.",
)  # fmt: skip


@calibrate.callback()
def kinds() -> None:
    """Calibrate an instrument from what is known of a lamp or of the lines in its spectra."""


@calibrate.command()
def response(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="SPECTRUM...",
            help="Spectra of the lamp, or of samples with many lines: better five and unlike.",
        ),
    ],
    lamp: Annotated[
        Path | None,
        typer.Option(
            "--lamp",
            metavar="CSV",
            help="The lamp's certificate: wavelength in nm, and radiance or irradiance per nm; "
            "without it, the lines of all spectra together tell the response.",
        ),
    ] = None,
    dark: Annotated[
        Path | None,
        typer.Option(metavar="SPECTRUM", help="Taken with the lamp off; it is subtracted."),
    ] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="The file to write.")] = Path(
        "response.csv"
    ),
) -> None:
    """Measure the response along the axis: from a lamp with a certificate, or from lines."""
    from ..spectrum.response import write_response

    try:
        if lamp is not None:
            found, how = _by_lamp(files, lamp, dark)
        elif dark is not None:
            raise ValueError("--dark needs --lamp")
        else:
            found, how = _by_lines(files, output)
        output.parent.mkdir(parents=True, exist_ok=True)
        made = datetime.now(UTC).astimezone().isoformat(timespec="seconds")
        write_response(found, output, [f"labrun calibrate response, {made}", how])
    except ValueError as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None
    except OSError as fault:
        say(f"{fault.filename or output}: {fault.strerror or fault}")
        raise typer.Exit(FAILED if fault.filename in (None, str(output)) else PROBLEMS) from None
    lowest = found.response.argmin()
    typer.echo(how)
    typer.echo(
        f"{found.wavelength_nm[0]:.0f} to {found.wavelength_nm[-1]:.0f} nm; lowest "
        f"{found.response[lowest]:.3g} ± {100 * found.error[lowest]:.0f} % "
        f"at {found.wavelength_nm[lowest]:.0f} nm, 1 at the highest"
    )
    typer.echo(f"wrote {output}; use it with: labrun reduce SPECTRA --response {output}")


@calibrate.command()
def standards(
    table: Annotated[
        Path,
        typer.Argument(
            metavar="STANDARDS.csv",
            help="A row for each standard: `sample`, and its concentrations in columns such as "
            "`Li (ppm)` or `SiO2 (wt %)`; with `file`, the names of its spectra.",
        ),
    ],
    files: Annotated[
        list[Path],
        typer.Argument(metavar="SPECTRA...", help="Spectra of the standards, or folders of them."),
    ],
    normalise: Annotated[
        str | None,
        typer.Option(
            help="Divide areas by nothing (none), by the total light (light), or by the area of an "
            "internal standard (its symbol).",
            show_default="none or light, as cross-validates better",
        ),
    ] = None,
    line: Annotated[
        list[str] | None,
        typer.Option(metavar="EL=NM", help="Another line of an element: Li=610.36 (nm in air)."),
    ] = None,
    curve: Annotated[
        str | None,
        typer.Option(
            help="straight or quadratic.", show_default="quadratic where it cross-validates better"
        ),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            help="lines: curves of single lines; pls: PLS regressions of whole spectra (extra `quant`).",
            show_default="of each element the better; lines where one of the options above is given",
        ),
    ] = None,
    closure: Closure = None,
    lines: OwnLines = None,
    response: KnownResponse = None,
    by: Annotated[
        str | None, typer.Option(help="Who calibrates.", show_default="the user's name")
    ] = None,
    note: Annotated[
        str, typer.Option(help="The instrument and its settings: laser, delay, gate, gas.")
    ] = "",
    output: Annotated[Path, typer.Option("-o", "--output", help="The file to write.")] = Path(
        "standards.calibration"
    ),
    figures: Annotated[
        bool, typer.Option("--figures/--no-figures", help="Draw the curves.")
    ] = True,
) -> None:
    """Make a calibration from spectra of standards, for `labrun reduce --calibration`."""
    from .standards import Asked, calibrate_standards

    asked = Asked(
        table,
        files,
        normalise,
        line or [],
        curve,
        model,
        closure,
        lines,
        response,
        by,
        note,
        output,
        figures,
    )
    try:
        for text in calibrate_standards(asked):
            typer.echo(text)
    except ValueError as fault:
        for text in str(fault).splitlines():
            say(text)
        raise typer.Exit(PROBLEMS) from None
    except OSError as fault:
        say(f"{fault.filename or output}: {fault.strerror or fault}")
        raise typer.Exit(FAILED if fault.filename in (None, str(output)) else PROBLEMS) from None


def _by_lamp(files: list[Path], lamp: Path, dark: Path | None) -> tuple[Any, str]:
    import numpy as np

    from ..elements.calibrate_response import from_lamp
    from ..spectrum.bad import mark_bad
    from ..spectrum.spectrum import Spectrum

    certificate = _read(lamp, ("1", "2"))
    if len(certificate) < 2 or not (certificate.intensity > 0).all():
        raise ValueError(
            f"{lamp}: a certificate has two wavelengths or more, and a radiance above 0 at each"
        )
    spectra = [_read(path) for path in (*files, *([dark] if dark else []))]
    x, paths = spectra[0].wavelength_nm, [*files, *([dark] if dark else [])]
    _one_axis(paths, spectra)
    for path, one in zip(paths, spectra, strict=True):
        if full := int(mark_bad(one.intensity, alone=False).full.sum()):
            raise ValueError(f"{path}: {full:,} channels are full; expose it for a shorter time")
    counts = np.mean([one.intensity for one in spectra[: len(files)]], axis=0)
    counts = counts - spectra[-1].intensity if dark else counts
    shots = f"the mean of {len(files)} spectra" if len(files) > 1 else files[0].name
    minus = "nothing subtracted: --dark takes a spectrum with the lamp off"
    minus = minus if dark is None else f"less {dark.name}"
    found = from_lamp(Spectrum(x, counts), certificate.wavelength_nm, certificate.intensity)
    return found, f"{shots}, {minus}, over {lamp.name}"


def _by_lines(given: list[Path], output: Path) -> tuple[Any, str]:
    from ..batch.gather import gather
    from ..elements.calibrate_response import ENOUGH_SPECTRA, from_lines
    from ..elements.merged import without_merged
    from ..reduce import reduce_spectrum

    files = [one.path for one in gather(given, output).spectra]
    if not files:
        raise ValueError(f"no spectra in {', '.join(map(str, given))}")
    # All are read before the first is reduced: what cannot be is told before minutes of compiling.
    spectra = [_read(path) for path in files]
    _one_axis(files, spectra)
    found = []
    for spectrum in spectra:
        reduction = reduce_spectrum(spectrum)
        own = reduction.identified
        found.append(None if own is None else without_merged(own, reduction.profiles))
    told = from_lines(spectra[0].wavelength_nm, found)
    response, (first, last) = told.response, told.range_nm
    unsure = [f"{nm:.0f}" for nm in response.wavelength_nm[response.error > UNSURE]]
    places = f"; hardly told (error above {100 * UNSURE:.0f} %) at {', '.join(unsure)} nm"
    few = f"; what fewer than {ENOUGH_SPECTRA} plasmas lack may be taken for the instrument's"
    return response, (
        f"lines from {first:.0f} to {last:.0f} nm of {told.spectra} of {len(files)} spectra"
        f"{places if unsure else ''}{few if told.spectra < ENOUGH_SPECTRA else ''}"
    )


def _one_axis(files: list[Path], spectra: list[Any]) -> None:
    """Raises ValueError for one of another instrument."""
    import numpy as np

    x = spectra[0].wavelength_nm
    for path, one in zip(files, spectra, strict=True):
        if len(one) != len(x) or not np.allclose(one.wavelength_nm, x, rtol=0, atol=SAME_NM):
            raise ValueError(
                f"{path}: its wavelengths are not those of {files[0]}; a response is of one instrument"
            )


def _read(path: Path, columns: tuple[str, ...] | None = None) -> Any:
    from ..spectrum.read import read_spectrum

    try:
        return read_spectrum(path, columns=columns).without_bad()
    except ValueError as fault:
        raise ValueError(f"{path}: {fault}") from None
