"""Every column of a table has a unique name.

E409. What each iteration of a loop collects is a row of `data.csv`. Its first column is `key`, its
last is `fate`, and a column of quantities has its unit after its name: `x` in mm is `x_mm`. No
program that reads the table can tell apart two columns of the same name.

Passes:

    devices: {balance: balance@1}
    steps:
      - foreach: {vial: [A, B, C]}
        key: ${{ vial }}
        steps:
          - {id: weight, do: balance.weigh}
        collect:
          mass: ${{ steps.weight.mass }}

Fails:

    devices: {balance: balance@1}
    steps:
      - foreach: {vial: [A, B, C]}
        key: ${{ vial }}
        steps:
          - {id: weight, do: balance.weigh}
        collect:
          key: ${{ vial }}
          mass: ${{ steps.weight.mass }}
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import LoopBase
from ..survey.spots import Spot
from .context import Context

CODES = {"E409": "a column with the name of another column"}
TAKEN = {"key": "the iteration's key", "fate": "how the iteration ended"}


def check(context: Context) -> Iterator[Problem]:
    """Every `collect`."""
    spots = {spot.place: spot for spot in context.survey.spots if spot.use == "collect"}
    for step, at in context.steps(LoopBase):
        place = (*at.place, "collect")
        columns = step.collect or {}
        headers = {name: _header(name, spots.get((*place, name))) for name in columns}
        seen: dict[str, str] = {}
        for name, header in headers.items():
            message = ""
            if header in TAKEN:
                message = f"every table already has a column {header}: {TAKEN[header]}"
            elif header in seen:
                message = f"{name} and {seen[header]} are both written as the column {header}"
            seen.setdefault(header, name)
            if message:
                yield context.source.problem(
                    (*place, name), "E409", message, "choose another name", key=True
                )


def _header(name: str, spot: Spot | None) -> str:
    """The name of a column with its unit, as in the table."""
    unit = spot.inferred()[0].unit if spot is not None else None
    if not unit:
        return name
    from ...schemas.quantity import UnitError, unit_of
    from ..run.rows import suffix

    try:
        return name + suffix(f"{unit_of(unit):~}")
    except UnitError:
        return name
