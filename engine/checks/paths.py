"""Files are kept in the run's folder.

E212. The engine and a device need not share a disk: files travel with the run, and every path is
inside the run's folder, such as `spectra/point_1.csv`. A path that leads out of it (`../`, `/data`,
`C:\\Spectra`) is rejected when the run reaches it; on Windows also a name that no file has there, such as
`11:30.csv` or `nul.csv`.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.export, with: {shot: shot-1, file: spectra/shot-1.csv}}

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.export, with: {shot: shot-1, file: /data/spectra/shot-1.csv}}
"""

from collections.abc import Iterator
from pathlib import Path

from ...schemas.problem import Problem
from ..language.expression import ExpressionError
from ..language.fold import fold
from ..language.value import Text, Value
from ..run.names import FileFault, NoFileName, inside
from ..survey.spots import Spot
from .context import Context

CODES = {"E212": "a path that leads out of the run's folder, or names no file on this system"}
HERE = Path()
AND_SO_ON = "…"


def check(context: Context) -> Iterator[Problem]:
    """Every argument that names a file, as far as its beginning is known."""
    for step, at, _, action in context.survey.actions():
        for name in (*action.path_params()[0], *action.path_params()[1]):
            spot = at.arguments.get(name)
            path = beginning(spot) if spot is not None else None
            if spot is None or path is None:
                continue
            try:
                inside(HERE, path)
            except NoFileName as fault:
                message = f"{step.do}.{name}: {str(fault).replace(AND_SO_ON, '')}"
                yield context.source.problem(spot.place, "E212", message)
            except FileFault:
                message = f"{step.do}.{name}: {path.removesuffix(AND_SO_ON)!r} leads out of the run's folder"
                hint = "write a path inside it, such as spectra/point_1.csv"
                yield context.source.problem(spot.place, "E212", message, hint)


def beginning(spot: Spot) -> str | None:
    """The path, or its text up to the first value that is not known yet."""
    value = spot.value
    if not isinstance(value, Value) or spot.inferred()[1]:
        return None
    folding = spot.env.folding()
    folded = fold(value, folding)
    if folded.known and not folded.loops:
        return folded.value if isinstance(folded.value, str) and folded.value else None
    if not isinstance(value, Text):
        return None
    known = ""
    for part in value.parts:
        try:
            found = fold(Text([part]), folding)
        except ExpressionError:
            break
        if not found.known or found.loops:
            break
        known += str(found.value)
    return known + AND_SO_ON if known else None
