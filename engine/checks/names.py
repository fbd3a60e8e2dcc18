"""A `do` names a role and one of the actions of that role's contract.

The role is one of those under `devices:`; what its device can do is in the contract, and
`labrun devices` lists it. A misspelt name would otherwise be found hours into a run.

Passes:

    labrun: 1
    name: names
    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home

Fails (E202, and E201 for the second):

    labrun: 1
    name: names
    devices: {gantry: gantry@1}
    steps:
      - do: gantry.hoem
      - do: gantrie.home
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Do
from ..context import Context
from ..language.suggest import did_you_mean, listed

CODES = {
    "E201": "a role that the protocol does not declare",
    "E202": "an action that the device does not have",
}


def check(context: Context) -> Iterator[Problem]:
    """Every `do`, its role first."""
    declared = context.source.names("devices")
    if not declared and not context.whole:
        return  # `devices` itself could not be read, which is said already
    for step, at in context.steps(Do):
        role, _, action = step.do.partition(".")
        place = (*at.place, "do")
        if role not in declared:
            known = (
                f"roles: {listed(declared)}"
                if declared
                else "declare it: `devices: {gantry: gantry@1}`"
            )
            message = f"{step.do}: there is no role {role}{did_you_mean(role, declared)}"
            yield context.source.problem(place, "E201", message, known)
        elif role in context.roles and action not in context.roles[role].contract.actions:
            contract = context.roles[role].contract
            guess = did_you_mean(action, contract.actions)
            message = f"{step.do}: {contract.type} has no action {action}{guess}"
            yield context.source.problem(
                place, "E202", message, f"it has {listed(contract.actions)}"
            )
