"""How long all of `finally` may take: a device that hangs must not keep the others from their safe state."""

from collections.abc import Iterable, Mapping
from typing import Any

from ...schemas.protocol import FINALLY_S, Step, StepBase, Wait, inner_lists
from ...schemas.quantity import seconds
from ..language.expression import ExpressionError
from ..language.value import value_of


def limit_s(every: Iterable[tuple[Iterable[Step], Mapping[str, Any]]]) -> float:
    """For several `finally`, each with its names: a furnace that comes down has its `timeout: 6 h`."""
    return FINALLY_S + sum(_stated_s(steps, names) for steps, names in every)


def _stated_s(steps: Iterable[Step], names: Mapping[str, Any]) -> float:
    """The seconds that steps state for themselves, all together; `defaults` state none."""
    return sum(_of_step(step, names) for step in steps)


def _of_step(step: StepBase, names: Mapping[str, Any]) -> float:
    said = step.timeout
    if said is None and isinstance(step, Wait) and step.until is None:
        said = step.wait
    if said is None:
        return sum(_stated_s(steps, names) for _, steps in inner_lists(step))
    try:
        return seconds(value_of(said).evaluate(names))
    except (ExpressionError, ValueError):  # the step itself says so when it begins
        return 0.0
