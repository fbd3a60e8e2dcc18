"""`labrun lines Li --from 600 --to 700`: the lines of an element in the line table."""

from typing import Annotated

import typer

from .words import OwnLines

Element = Annotated[str, typer.Argument(help="Element symbol, such as Li.", show_default=False)]
From = Annotated[
    float | None, typer.Option("--from", help="Shortest wavelength, in nm.", metavar="NM")
]
To = Annotated[float | None, typer.Option("--to", help="Longest wavelength, in nm.", metavar="NM")]
Stage = Annotated[int | None, typer.Option(help="1 for atoms (I), 2 for ions (II).", metavar="1|2")]
Medium = Annotated[str, typer.Option(help="Wavelengths in air or vacuum.")]
Temperature = Annotated[
    float, typer.Option("--temperature", "-T", help="Temperature for the strengths, in K.")
]
Density = Annotated[float, typer.Option(help="Electron density for the strengths, per cm3.")]
Strongest = Annotated[int | None, typer.Option(help="Only the N strongest.", metavar="N")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]


def lines(
    element: Element,
    from_nm: From = None,
    to_nm: To = None,
    stage: Stage = None,
    medium: Medium = "air",
    temperature: Temperature = 10_000.0,
    density: Density = 1e17,
    strongest: Strongest = None,
    lines: OwnLines = None,
    json: Json = False,
) -> None:
    """Print an element's lines: wavelength, transition probability, levels, accuracy, strength.

    The strength is for an optically thin plasma in equilibrium (Saha and Boltzmann), scaled to 100
    for the element's strongest line in the table, over both stages.
    """
    from .listing import Wanted, list_lines

    wanted = Wanted(element, from_nm, to_nm, stage, medium, temperature, density, strongest)
    raise typer.Exit(list_lines(wanted, lines, json))
