"""A `retry` retries only what may succeed the next time.

W413. A retry that changes nothing gives a false sense of safety: a single attempt, a step that
cannot end differently the second time, a `factor` without a `wait` to multiply.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, retry: {attempts: 2, wait: 5 s, factor: 2}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, retry: {attempts: 1, wait: 5 s}}

W414. An action that is `once` in its contract (a laser shot, a dispensed drop) is retried only if
it certainly did not happen. After an error that leaves this open, such as Timeout, the step's
`on_unknown` decides, and a retry that names the error has no effect.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - do: libs.measure
        retry: {attempts: 3, on: [ButtonNotFound, Busy]}
        on_unknown: probe
    finally: [{do: libs.disarm}]

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - do: libs.measure
        retry: {attempts: 3, on: [ButtonNotFound, Timeout]}
    finally: [{do: libs.disarm}]
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Fail, Log, Require, Retry, Set, StepBase, Wait
from ..language.shape import Place
from .constant import constant
from .context import Context

CODES = {
    "W413": "a retry that changes nothing",
    "W414": "a retry after an error that leaves a `once` action open",
}
THE_SAME_AGAIN = {Log: "log", Set: "set", Wait: "wait", Require: "require", Fail: "fail"}


def check(context: Context) -> Iterator[Problem]:
    """Every `retry`, including that of `defaults`."""
    yield from _numbers(context, context.protocol.defaults.retry, ("defaults", "retry"))
    for at in context.survey.steps:
        if at.step.retry is None:
            continue
        place = (*at.place, "retry")
        useless = _useless(at.step)
        if useless:
            message = f"a retry has no effect on `{useless}`: it ends the same way each time"
            hint = "put the `retry` on the step whose result it depends on"
            yield _warning(context, place, message, hint, key=True)
        else:
            yield from _numbers(context, at.step.retry, place)
    yield from _open_fates(context)


def _useless(step: StepBase) -> str:
    return next((word for kind, word in THE_SAME_AGAIN.items() if isinstance(step, kind)), "")


def _warning(
    context: Context, place: Place, message: str, hint: str = "", *, key: bool = False
) -> Problem:
    return context.source.problem(place, "W413", message, hint, key=key)


def _numbers(context: Context, retry: int | Retry | None, place: Place) -> Iterator[Problem]:
    if retry == 1:
        yield _warning(context, place, _ONE, _TWO)
    if not isinstance(retry, Retry):
        return
    if retry.attempts == 1:
        yield _warning(context, (*place, "attempts"), _ONE, _TWO)
        return
    waits = not (constant(retry.wait).known and retry.wait in (0, 0.0))
    for name, nothing in (("factor", 1.0), ("jitter", 0.0), ("max_wait", None)):
        if not waits and getattr(retry, name) != nothing:
            message = f"{name} does nothing without a `wait`"
            yield _warning(context, (*place, name), message, "add `wait: 1 s`", key=True)
    if waits and retry.max_wait is not None and retry.factor == 1.0 and not retry.jitter:
        message = "max_wait does nothing without a `factor`: every wait is as long as the first"
        yield _warning(context, (*place, "max_wait"), message, "add `factor: 2`", key=True)


_ONE = "one attempt in all, including the first: nothing is retried"
_TWO = "2 means one retry"


def _open_fates(context: Context) -> Iterator[Problem]:
    for step, at, _, action in context.survey.actions():
        named = step.retry.on if isinstance(step.retry, Retry) else None
        if action.effect != "once" or not named:
            continue
        for index, name in enumerate(named):
            if action.happened(name) == "unknown":
                message = (
                    f"after {name} it is not known whether {step.do} happened, "
                    "so this retry never sends it again"
                )
                hint = "`on_unknown: probe | ask | skip | repeat` decides what happens then"
                place = (*at.place, "retry", "on", index)
                yield context.source.problem(place, "W414", message, hint)
