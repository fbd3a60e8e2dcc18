"""Descriptions of the keys for editors, in addition to those of the models."""

import inspect

from pydantic import BaseModel

from ...schemas.protocol import STEP_KINDS

WORDS = {
    "labrun": "The version of the protocol language: 1.",
    "Protocol.name": "The name of the protocol and of its runs.",
    "summary": "One line that says what it is for.",
    "params": "Values set by `-p name=value`, on the page or by a caller: name -> declaration.",
    "Protocol.devices": "The roles: name -> contract. The lab or `--bind role=device` chooses the devices.",
    "functions": "Functions of your own: name -> ./file.py:function; called in a `set`.",
    "defaults": "Settings for every step that does not give its own.",
    "Protocol.steps": "The steps of the protocol, in order.",
    "on_resume": "Steps that run when a run is resumed after a stop or a crash, such as homing.",
    "finally": "Steps that always run at the end: on success, failure and abort.",
    "outputs": "Named results of the whole run: name -> value or ${{ ... }}.",
    "Param.type": "The kind of value.",
    "unit": "The unit of a quantity, such as mm, s or uL.",
    "default": "The value if none is given; without a default, a value is required.",
    "minimum": "The lowest value allowed.",
    "maximum": "The highest value allowed.",
    "pattern": "A regular expression that the text must match.",
    "enum": "The only values allowed.",
    "Param.items": "The JSON Schema of each item of an array.",
    "id": "A name for the step; others read its result as ${{ steps.ID.field }}.",
    "name": "Shown to people instead of the id.",
    "when": "An expression; if it is false, the step is skipped and its result is null.",
    "timeout": "The time limit: for each attempt of a `do`, in total for other steps.",
    "Defaults.timeout": "The timeout of every `do` without its own.",
    "retry": "The number of attempts in total: 3, or {attempts, wait, factor, ...}.",
    "background": "How many iterations of a loop may be unfinished while the next one runs.",
    "attempts": "The number of attempts in total, including the first.",
    "until": "A time of day such as 07:00, the next one; a date with its time; or a moment.",
    "Retry.wait": "The wait before the next attempt.",
    "factor": "The factor by which the wait grows from attempt to attempt.",
    "max_wait": "The longest wait that `factor` may lead to.",
    "jitter": "A random share of the wait, from 0 to 1.",
    "on": "Retry only after these errors; the contract of the device names them.",
    "max_failed": "How many iterations may fail before the loop does.",
    "in_a_row": "How many iterations may fail one after the other before the loop does.",
    "fallback": "Alternatives in order, each a step or a list of steps; the first that succeeds counts.",
    "on_error": "What to do if the step finally fails.",
    "on_unknown": "What to do if it is not known whether a `once` action happened.",
    "on_failure": "What happens to the other members when one fails.",
    "Do.with": "The parameters of the action.",
    "Use.with": "The parameters of the other protocol.",
    "Use.devices": "Its role -> our role; not needed for roles of the same name.",
    "mode": "background: the next step starts at once; outside loops it is awaited at the end of the list.",
    "steps": "The steps inside.",
    "then": "The steps if it is true.",
    "else": "The steps if it is false.",
    "max": "The most iterations; if the condition is still true, the loop fails with MaxReached.",
    "key": "The permanent identity of an iteration, such as ${{ point.index }}.",
    "keep_going": "How many iterations may fail before the loop does; a failed one leaves a gap.",
    "collect": "One row of data.csv per iteration: column -> value or ${{ ... }}.",
    "choices": "The possible answers.",
    "reserve": "Devices that this group has for itself until it ends; it waits until all of them are free.",
    "at_once": "How many iterations may run at the same time; they take turns on their devices.",
    "order": "In which order the iterations begin: as listed, or so that all together take the least time.",
    "watch": "What is looked at while the steps run, and what happens when it is so.",
    "every": "How often it is looked at; without it, whenever a device tells its status.",
    "Watch.when": "The condition; status.ROLE.FIELD is what a device tells of itself.",
    "Watch.then": "Steps that take the place of those watched (notify and log leave them), or pause.",
    "Watch.do": "An action that only reads, done each time before the condition is computed.",
    "Watch.with": "The parameters of the action.",
    "Watch.id": "The condition has what `do` read as steps.ID.",
    "stale": "What nobody has known for so long counts as true; if not given, 3 x `every` (at least 5 s).",
    "on_stale": "What to do when nobody knows any more.",
    "picture": "A picture in the run's folder that goes with it.",
}
CHOICES = {
    "Param.type": {
        "quantity": "a number with a unit, such as 0.2 mm",
        "number": "a number without a unit",
        "integer": "a whole number",
        "string": "text",
        "boolean": "true or false",
        "array": "a list",
    },
    "on_error": {
        "stop": "the run fails (the default)",
        "continue": "the next step runs anyway",
        "pause": "the run waits for a person",
    },
    "on_unknown": {
        "probe": "ask the device, then a person (the default)",
        "ask": "ask a person",
        "skip": "skip this iteration",
        "repeat": "send it again: it may then happen twice",
    },
    "on_failure": {
        "finish": "the others run to their end (the default)",
        "cancel": "the others are stopped",
    },
    "on_stale": {
        "then": "it counts as true (the default): a dead sensor is no safety",
        "ignore": "only what is known counts",
    },
    "Foreach.order": {
        "listed": "as the items are listed (the default)",
        "shortest": "so that all together take the least time, by the durations in the contracts",
    },
    "mode": {"background": "the next step starts at once"},
}


def words_for(model: type[BaseModel], key: str) -> str:
    """The description of a key; for the keyword of a step, that of its model."""
    if model in STEP_KINDS and key == getattr(model, "KIND", None):
        return about(model)
    return WORDS.get(f"{model.__name__}.{key}") or WORDS.get(key, "")


def choices_for(model: type[BaseModel], key: str) -> dict[str, str]:
    """The description of each choice of a key."""
    return CHOICES.get(f"{model.__name__}.{key}") or CHOICES.get(key, {})


def about(model: type[BaseModel]) -> str:
    """The description of a model: its docstring."""
    return inspect.getdoc(model) or ""
