"""`labrun lines Li --from 600 --to 700`: the lines of an element, as the table has them."""

from typing import Annotated

import typer

Element = Annotated[str, typer.Argument(help="Its symbol.", show_default=False)]
From = Annotated[float | None, typer.Option("--from", help="nm", metavar="NM")]
To = Annotated[float | None, typer.Option("--to", help="nm", metavar="NM")]
Stage = Annotated[int | None, typer.Option(help="1 for atoms (I), 2 for ions (II).", metavar="1|2")]
Medium = Annotated[str, typer.Option(help="air or vacuum: of the wavelengths.")]
Temperature = Annotated[float, typer.Option("--temperature", "-T", help="K, for the strengths.")]
Density = Annotated[float, typer.Option(help="Electrons per cm3, for the strengths.")]
Strongest = Annotated[int | None, typer.Option(help="Only so many.", metavar="N")]
Json = Annotated[bool, typer.Option("--json", help="As JSON.")]


def lines(
    element: Element,
    from_nm: From = None,
    to_nm: To = None,
    stage: Stage = None,
    medium: Medium = "air",
    temperature: Temperature = 10_000.0,
    density: Density = 1e17,
    strongest: Strongest = None,
    json: Json = False,
) -> None:
    """Print an element's lines: wavelength, transition probability, levels, accuracy, strength.

    The strength is that of a thin plasma in equilibrium (Saha and Boltzmann), 100 for the strongest
    of the element within the table's range, both stages together.
    """
    from .listing import Wanted, list_lines

    wanted = Wanted(element, from_nm, to_nm, stage, medium, temperature, density, strongest)
    raise typer.Exit(list_lines(wanted, json))
