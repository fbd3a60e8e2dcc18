"""`labrun map DIR`: element maps and classes from the rows of a run and its reduced spectra."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .words import FAILED, PROBLEMS, counted, say, symbols

if TYPE_CHECKING:
    from ..map_folder import MapResult

FOLDER = "maps"
COLUMNS = 7  # elements in the printed table


def map(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A run, or a folder of tables.")],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Where to write; DIR/maps without it.")
    ] = None,
    elements: Annotated[
        str | None, typer.Option(help="Li,K,Si; without it those seen in enough points.")
    ] = None,
    features: Annotated[
        str | None,
        typer.Option(
            help="Elements that tell classes apart; Li,H without it, where both are seen."
        ),
    ] = None,
    classes: Annotated[
        int | None, typer.Option(min=1, max=8, help="How many; by silhouette without it.")
    ] = None,
    scale: Annotated[str, typer.Option(help="min-max, absolute or total.")] = "min-max",
    format: Annotated[str, typer.Option(help="png, svg or pdf.")] = "png",
) -> None:
    """Draw element maps and classes of a run, or of tables that `labrun reduce` wrote."""
    from ..figures.paper import FORMATS
    from ..map_choices import MapChoices
    from ..map_folder import map_folder
    from ..scales import SCALES

    if scale not in SCALES or format not in FORMATS:
        wrong = ("--scale", scale, SCALES) if scale not in SCALES else ("--format", format, FORMATS)
        say(f"{wrong[0]} {wrong[1]}: it is one of {', '.join(wrong[2])}")
        raise typer.Exit(PROBLEMS)
    try:
        asked, telling = symbols(elements, "--elements"), symbols(features, "--features")
        choices = MapChoices(asked, telling, classes, scale, format)
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
        by = ", as many as silhouette says" if classes.scores else ""
        typer.echo(f"{counted(len(classes), 'class')} from {', '.join(classes.features)}{by}")
        shown = list(dict.fromkeys([*classes.features, *result.elements]))[:COLUMNS]
        head = "".join(f"{element:>9}" for element in shown)
        typer.echo(f"{'class':>5} {'points':>6} {'silh.':>6}{head}  likely")
        for one in classes.summary:
            areas = "".join(f"{one.area[element]:9.4g}" for element in shown)
            typer.echo(f"{one.number:>5} {one.size:>6} {one.silhouette:6.2f}{areas}  {one.likely}")
    for path in result.written:
        typer.echo(f"made {path}")
