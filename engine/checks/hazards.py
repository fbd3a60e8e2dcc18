"""The protocol's own `finally` makes everything dangerous safe again.

W410. After every run each device that was used is put in the safe state of its contract. That is
the last safety net. Steps that make this particular experiment safe (laser off, heater down, tool
lifted, in this order) belong in `finally`, which runs on success, failure and abort. The warning
is given for lasers, heat and pressure, and for motion where the contract has no safe state.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.measure, timeout: 15 s}
    finally:
      - {do: libs.disarm, on_error: continue}

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.measure, timeout: 15 s}
"""

from collections.abc import Iterator

from ...schemas.contract import Action
from ...schemas.problem import Problem
from ...schemas.protocol import Do
from ..lab.bind import BoundRole
from ..language.suggest import listed
from .context import Context

CODES = {"W410": "a dangerous action without a `finally` for its device"}


def check(context: Context) -> Iterator[Problem]:
    """The first dangerous action of each role that no step of `finally` addresses."""
    if context.used or not context.whole:
        return
    ended = {
        step.do.partition(".")[0] for step, at in context.steps(Do) if at.place[0] == "finally"
    }
    for step, at, bound, action in context.survey.actions():
        role = step.do.partition(".")[0]
        if role in ended or not _wants_an_end(bound, action):
            continue
        ended.add(role)
        message = f"{step.do} is dangerous ({action.danger}), and no `finally` makes {role} safe"
        yield context.source.problem((*at.place, "do"), "W410", message, _hint(role, bound))


def _wants_an_end(bound: BoundRole, action: Action) -> bool:
    if action.danger is None:
        return False
    return action.danger != "motion" or not bound.contract.safe_state


def _hint(role: str, bound: BoundRole) -> str:
    safe = bound.contract.safe_state
    if not safe:
        return f"{bound.contract.type} has no safe state; add `finally: [{{do: {role}.ACTION}}]`"
    example = f"finally: [{{do: {role}.{safe[0]}, on_error: continue}}]"
    return f"its safe state is {listed(safe)}; write it yourself, too: `{example}`"
