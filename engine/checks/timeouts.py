"""Every action has a time limit.

W401. If the contract says how long an action usually takes (`duration`), a run notices when it
hangs. If not, only a `timeout` of the step, or `defaults: {timeout: 30 s}`, ends the wait.

Passes:

    devices: {oven: oven@1}
    steps:
      - {do: oven.heat, timeout: 2 h}

Fails:

    devices: {oven: oven@1}
    steps:
      - do: oven.heat

Beside it, oven.yaml:

    type: oven@1
    actions:
      heat: {effect: idempotent}

Beside it, lab.yaml:

    contracts: [oven.yaml]
    devices: {oven: {contract: oven@1, url: "http://10.0.0.9:4101"}}

W402. A timeout shorter than the usual duration ends actions that are working correctly. Where a parameter
says how long an action takes, as that of `furnace.hold` does, it counts.

`finally` ends after 10 min, so that a device that hangs does not keep the others from their safe state. A
step there that takes longer states its `timeout` itself, and the limit grows by it.

Passes:

    devices: {gantry: gantry@1, furnace: furnace@1}
    steps:
      - {do: gantry.home, timeout: 120 s}
      - {do: furnace.hold, with: {duration: 10 min}, timeout: 20 min}
    finally:
      - {do: furnace.ramp, with: {to: 300 degC, rate: 5 K/min}, timeout: 6 h}
      - {do: furnace.off, on_error: continue}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, timeout: 1 s}
"""

from collections.abc import Iterator, Sequence

from ...schemas.contract import Action
from ...schemas.problem import Problem
from ...schemas.protocol import FINALLY_S, Do, Step, inner_lists
from ...schemas.quantity import UnitError, magnitude_in, seconds
from .context import Context

CODES = {
    "W401": "an action without a time limit: no timeout, no duration",
    "W402": "a timeout shorter than the action usually takes",
}


def check(context: Context) -> Iterator[Problem]:
    """Every `do` whose action is known."""
    default = context.protocol.defaults.timeout
    in_finally = set(_without_own(context.protocol.finally_))
    for step, at, _, action in context.survey.actions():
        limit = step.timeout if step.timeout is not None else default
        if limit is None and action.duration is None and not action.takes:
            message = f"{step.do} may hang for ever: it has no timeout, and its contract gives no duration"
            yield context.source.problem((*at.place, "do"), "W401", message, "add `timeout: 30 s`")
        usual, given = _usual_s(step, action), _seconds(limit)
        if usual is not None and given is not None and 0 < given < usual:
            place = (*at.place, "timeout") if step.timeout is not None else (*at.place, "do")
            usually = _usually(step, action, usual)
            message = f"{step.do} usually takes {usually}; the timeout of {limit} ends it early"
            yield context.source.problem(place, "W402", message)
        if usual is not None and usual > FINALLY_S and id(step) in in_finally:
            ends, usually = f"{FINALLY_S / 60:g} min", _usually(step, action, usual)
            message = f"{step.do} usually takes {usually}; `finally` ends after {ends}"
            hint = f"a `timeout` of its own, such as `timeout: 6 h`, is added to the {ends}"
            yield context.source.problem((*at.place, "do"), "W402", message, hint)


def _without_own(steps: Sequence[Step]) -> Iterator[int]:
    """The actions for which neither they nor a step around them states a time."""
    for step in steps:
        if step.timeout is None:
            if isinstance(step, Do):
                yield id(step)
            for _, inner in inner_lists(step):
                yield from _without_own(inner)


def _usually(step: Do, action: Action, usual_s: float) -> object:
    return step.with_.get(action.takes, action.duration or f"{usual_s:g} s")


def _usual_s(step: Do, action: Action) -> float | None:
    """Seconds that it takes by its parameter, else by its contract; None if not known before the run."""
    if action.takes not in step.with_:
        return action.typical_s({})
    unit = action.param_schemas()[action.takes]["unit"]
    try:
        return action.typical_s({action.takes: magnitude_in(step.with_[action.takes], unit)})
    except (UnitError, ValueError, TypeError):
        return None  # reported by the family `calculations`, or not known yet


def _seconds(duration: object) -> float | None:
    if duration is None or isinstance(duration, bool):
        return None
    try:
        return seconds(duration)
    except (UnitError, ValueError, TypeError):
        return None  # reported by the family `calculations`, or not known yet
