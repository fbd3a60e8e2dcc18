"""Functions of one's own are there, say what they take and give, and are called in a `set`.

E314. `functions: {drift: ./analysis.py:drift}` names a function in a Python file in the protocol's folder or
below. Its file is read and never imported by the check, so what it takes and gives is what its
annotations say, with units: `Annotated[float, "mm"]`. The run keeps a copy of the file.

Passes:

    functions: {drift: ./analysis.py:drift}
    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh}
      - set: {off: "${{ drift([steps.weight.mass, 2 g]) }}"}
      - log: ${{ off }}

Fails:

    functions: {drift: ./analysis.py:drifts}
    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh}
      - set: {off: "${{ drift([steps.weight.mass, 2 g]) }}"}
      - log: ${{ off }}

Beside it, analysis.py:

    from typing import Annotated

    def drift(masses: list[Annotated[float, "g"]]) -> Annotated[float, "g"]:
        return max(masses) - min(masses)

E315. A function of one's own runs in a process of its own and may take a while, in which devices go on
being watched. So it is called in a `set`, whose `timeout` is its limit; other steps use the name.

Passes:

    functions: {drift: ./analysis.py:drift}
    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh}
      - set: {off: "${{ drift([steps.weight.mass, 2 g]) }}"}
      - {log: drifting, when: "${{ off > 1 g }}"}

Fails:

    functions: {drift: ./analysis.py:drift}
    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh}
      - {log: drifting, when: "${{ drift([steps.weight.mass, 2 g]) > 1 g }}"}

Beside it, analysis.py:

    from typing import Annotated

    def drift(masses: list[Annotated[float, "g"]]) -> Annotated[float, "g"]:
        return max(masses) - min(masses)
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ..language.own_functions import FunctionFault
from ..language.suggest import listed
from ..survey.scope import RESERVED
from .context import Context

CODES = {
    "E314": "a function of one's own that cannot be used",
    "E315": "a function of one's own called outside a `set`",
}


def check(context: Context) -> Iterator[Problem]:
    """Every function that is declared, and every place that calls one."""
    source = context.source
    for name, found in context.survey.functions.items():
        if name in RESERVED:
            message = f"{name} already means something else in expressions"
            place = ("functions", name)
            yield source.problem(place, "E314", message, "choose another name", key=True)
        elif isinstance(found, FunctionFault):
            yield source.problem(("functions", name), "E314", f"{name}: {found}", found.hint)
    for spot in context.survey.spots:
        if spot.use == "set" or isinstance(spot.value, Exception):
            continue
        called = sorted({name for one in spot.value.expressions() for name in one.calls})
        if called:
            message = f"{listed(called)}: a function of one's own is called in a `set`"
            hint = f"write `- set: {{value: ${{{{ {called[0]}(...) }}}}}}` before, and use the name"
            yield source.problem(spot.place, "E315", message, hint)
