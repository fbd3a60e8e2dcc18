"""Every iteration writes a different file.

W417. An action that writes a file (`spectra/a.csv`) writes it again in each iteration. If two
iterations use the same file name, the second overwrites the first, and a scan of a thousand
points can end with one spectrum.

Passes:

    params: {sample: {type: string, default: core}}
    devices: {libs: libs_analyzer@1}
    steps:
      - foreach: {point: "${{ grid(x=span(0, 4, 1), y=span(0, 4, 1)) }}"}
        steps:
          - {id: last, do: libs.last_shot}
          - do: libs.export
            with:
              shot: ${{ steps.last.shot_id }}
              file: spectra/${{ params.sample }}_${{ point.ix }}_${{ point.iy }}.csv

Fails:

    params: {sample: {type: string, default: core}}
    devices: {libs: libs_analyzer@1}
    steps:
      - foreach: {point: "${{ grid(x=span(0, 4, 1), y=span(0, 4, 1)) }}"}
        steps:
          - {id: last, do: libs.last_shot}
          - do: libs.export
            with:
              shot: ${{ steps.last.shot_id }}
              file: spectra/${{ params.sample }}_${{ point.ix }}.csv
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ..language.grid import Grid
from ..language.value import Value
from ..survey.scope import Env, LoopName
from ..survey.spots import Spot
from .context import Context
from .loops import first_double

CODES = {"W417": "a file that each iteration overwrites"}
VARIES = {"steps", "run", "error"}
"""Names whose values may differ in each iteration and are not known before the run."""


def check(context: Context) -> Iterator[Problem]:
    """Every argument in a loop that names a file that the action writes."""
    for _, at, _, action in context.survey.actions():
        loops = [level for level in at.env.levels if level.kind == "loop"]
        if not loops:
            continue
        for name in action.path_params()[1]:
            spot = at.arguments.get(name)
            if spot is None or not isinstance(spot.value, Value) or spot.inferred()[1]:
                continue
            message = _why(spot, spot.value, len(loops))
            if message:
                yield context.source.problem(spot.place, "W417", message, _hint(spot, spot.value))


def _why(spot: Spot, value: Value, loops: int) -> str:
    if value.live:
        return ""
    env, names = spot.env, value.names
    if names & (VARIES | set(env.set_names())):
        return ""
    unnamed = [loop for loop in env.loops if loop.name not in names and _iterations(loop) != 1]
    if unnamed:
        return f"every iteration overwrites this file: its name does not use {unnamed[-1].name}"
    if loops > len(env.loops):
        return "" if names else "every iteration overwrites this file: its name is always the same"
    return _double(env, value, env.loops[-1]) if loops == 1 else ""


def _hint(spot: Spot, value: Value) -> str:
    if not spot.env.loops:
        return "loop over numbers, `foreach: {n: ${{ range(5) }}}`, and put ${{ n }} in the name"
    unnamed = [loop for loop in spot.env.loops if loop.name not in value.names]
    loop = (unnamed or spot.env.loops)[-1]
    field = ".index" if isinstance(loop.items, Grid) else ""
    return f"use something that differs between iterations, such as ${{{{ {loop.name}{field} }}}}"


def _iterations(loop: LoopName) -> int | None:
    return len(loop.items) if loop.items is not None else None


def _double(env: Env, value: Value, loop: LoopName) -> str:
    """Two iterations that write the same file, where their items are known."""
    double = first_double(value, loop, env.folding())
    return f"{double[0]} both write {double[1]} ({double[2]})" if double is not None else ""
