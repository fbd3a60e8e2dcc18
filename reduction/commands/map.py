"""`labrun map DIR`: element maps and classes from a run's rows and reduced spectra."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .run_name import or_run
from .words import FAILED, PROBLEMS, counted, say, symbols

if TYPE_CHECKING:
    from ..mapping.folder import MapResult

FOLDER = "maps"
COLUMNS = 7  # elements in the printed table


def map(
    folder: Annotated[
        Path,
        typer.Argument(metavar="DIR", help="A run, by its folder or name, or a folder of tables."),
    ],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Output folder; DIR/maps by default.")
    ] = None,
    elements: Annotated[
        str | None, typer.Option(help="Such as Li,K,Si; by default those seen at enough points.")
    ] = None,
    features: Annotated[
        str | None,
        typer.Option(help="Elements to classify by; by default Li,H, if both are seen."),
    ] = None,
    classes: Annotated[
        int | None,
        typer.Option(min=1, max=8, help="Number of classes; by default chosen by silhouette."),
    ] = None,
    scale: Annotated[
        str, typer.Option(help="Intensity scale: min-max, absolute or total.")
    ] = "min-max",
    format: Annotated[str, typer.Option(help="Figure format: png, svg or pdf.")] = "png",
    correct_drift: Annotated[
        bool,
        typer.Option(
            "--correct-drift", help="Correct wt % by the drift that check standards show."
        ),
    ] = False,
) -> None:
    """Draw element maps and classes for a run, or for tables written by `labrun reduce`."""
    from ..figures.paper import FORMATS
    from ..mapping.choices import MapChoices
    from ..mapping.folder import map_folder
    from ..maps.points.scales import SCALES

    folder = or_run(folder)
    if scale not in SCALES or format not in FORMATS:
        wrong = ("--scale", scale, SCALES) if scale not in SCALES else ("--format", format, FORMATS)
        say(f"{wrong[0]} {wrong[1]}: choose one of {', '.join(wrong[2])}")
        raise typer.Exit(PROBLEMS)
    try:
        asked, telling = symbols(elements, "--elements"), symbols(features, "--features")
        choices = MapChoices(asked, telling, classes, scale, format, correct_drift)
        result = map_folder(folder, folder / FOLDER if out is None else out, choices)
    except ValueError as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None
    except OSError as fault:
        say(f"{fault.filename or out or folder}: {fault.strerror or fault}")
        raise typer.Exit(FAILED) from None
    _print(result)


def _print(result: "MapResult") -> None:
    for note in result.notes:
        say(note)
    points, classes = result.points, result.classes
    typer.echo(f"{counted(len(points), 'point')}, {', '.join(result.elements)}")
    if classes is not None:
        by = ", number chosen by silhouette" if classes.scores else ""
        typer.echo(f"{counted(len(classes), 'class')} from {', '.join(classes.features)}{by}")
        shown = list(dict.fromkeys([*classes.features, *result.elements]))[:COLUMNS]
        head = "".join(f"{element:>11}" for element in shown)
        typer.echo(f"{'class':>5} {'points':>6} {'silh.':>6}{head}  likely")
        for one in classes.summary:
            areas = "".join(f"{one.area[element]:11.4g}" for element in shown)
            typer.echo(f"{one.number:>5} {one.size:>6} {one.silhouette:6.2f}{areas}  {one.likely}")
    for path in result.written:
        typer.echo(f"wrote {path}")
