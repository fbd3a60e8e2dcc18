"""What is declared is used; a parameter or a role that nothing uses is often a misspelt one.

Passes:

    labrun: 1
    name: unused
    params: {depth: {type: quantity, unit: mm, default: 1 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {z: "${{ params.depth }}"}}

Fails (W407, a warning):

    labrun: 1
    name: unused
    params: {depth: {type: quantity, unit: mm, default: 1 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {z: 1 mm}}
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Do
from ..context import Context
from ..language.fold import needs

CODES = {
    "W407": "a parameter that nothing uses",
    "W408": "a role that nothing uses",
}


def check(context: Context) -> Iterator[Problem]:
    """Parameters, then roles; silent where a part of the file could not be read."""
    if not context.whole:
        return
    used: set[str] = set()
    for spot in context.survey.spots:
        if isinstance(spot.value, Exception):
            return
        for expression in spot.value.expressions():
            wanted = needs(expression)
            if wanted is None:
                return
            used |= wanted[0]
    for name in context.protocol.params:
        if name not in used:
            yield context.source.problem(
                ("params", name),
                "W407",
                f"nothing uses the parameter {name}",
                key=True,
                severity="warning",
            )
    roles = {step.do.partition(".")[0] for step, _ in context.steps(Do)}
    for name in context.protocol.devices:
        if name not in roles:
            yield context.source.problem(
                ("devices", name),
                "W408",
                f"no step uses the role {name}",
                key=True,
                severity="warning",
            )
