"""`keep_going` has a limit that can be reached.

W416. `keep_going: {max_failed: N}` lets a loop continue after N failed iterations and stops it at
the next one. If the loop has no more than N iterations, the limit never stops it: it goes through all
of them, and fails only if not one succeeded. To mean that, write `keep_going: true`.

Passes:

    devices: {balance: balance@1}
    steps:
      - foreach: {vial: [A, B, C]}
        keep_going: {max_failed: 1}
        steps:
          - do: balance.weigh

Fails:

    devices: {balance: balance@1}
    steps:
      - foreach: {vial: [A, B, C]}
        keep_going: {max_failed: 3}
        steps:
          - do: balance.weigh
"""

from collections.abc import Iterator, Sequence

from ...schemas.problem import Problem
from ...schemas.protocol import Foreach, LoopBase, Repeat, While
from .constant import constant, fixed_count
from .context import Context

CODES = {"W416": "a limit on failures that cannot be reached"}


def check(context: Context) -> Iterator[Problem]:
    """Every loop whose number of iterations does not depend on parameters."""
    for step, at in context.steps(LoopBase):
        most = step.keep_going.max_failed if step.keep_going is not None else None
        allowed = None if most is None else fixed_count(most)
        total = _total(step)
        if allowed is None or not total or allowed < total:
            continue
        message = f"all {total} iterations may fail: the loop stops only after {allowed} failures"
        hint = f"a limit from 0 to {total - 1} can be reached"
        place = (*at.place, "keep_going", "max_failed")
        yield context.source.problem(place, "W416", message, hint)


def _total(step: LoopBase) -> int | None:
    """The maximum number of iterations of a loop; None where that is not fixed."""
    if isinstance(step, Repeat):
        return fixed_count(step.repeat)
    if isinstance(step, While):
        return fixed_count(step.max) if step.max is not None else None
    if not isinstance(step, Foreach):
        return None
    (raw,) = step.foreach.values()
    if isinstance(raw, list):
        return len(raw)
    found = constant(raw)
    is_list = found.known and isinstance(found.value, Sequence) and not isinstance(found.value, str)
    return len(found.value) if is_list else None
