"""A `do` names a role and one of the actions of that role's contract.

E201. The role must be declared under `devices:`. An undeclared role has no device, and the run
would stop at this step, perhaps hours after its start.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home

Fails:

    devices: {gantry: gantry@1}
    steps:
      - do: gantrie.home

E202. What a device can do is in its contract; `labrun devices` lists it. A misspelt action would
be rejected by the device only when the run reaches it.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home

Fails:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.hoem
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Do
from ..language.suggest import did_you_mean, listed
from .context import Context

CODES = {
    "E201": "a role that the protocol does not declare",
    "E202": "an action that the device does not have",
}


def check(context: Context) -> Iterator[Problem]:
    """Every `do`, its role first."""
    declared = context.source.names("devices")
    if not declared and not context.whole:
        return  # `devices` itself could not be read, which is already reported
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
