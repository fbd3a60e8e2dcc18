"""What an editor says of each key, beside what the models say of themselves."""

import inspect

from pydantic import BaseModel

from ...schemas.protocol import STEP_KINDS

WORDS = {
    "labrun": "The version of the protocol language: 1.",
    "Protocol.name": "What the protocol is called; its runs bear this name.",
    "summary": "One line that says what it is for.",
    "params": "What is set by `-p name=value`, by the page or by a caller: name -> declaration.",
    "Protocol.devices": "The roles: name -> contract. The lab, or `--bind role=device`, says who plays them.",
    "defaults": "What holds where a step says nothing else.",
    "Protocol.steps": "What is done, in this order.",
    "on_resume": "Steps that run when a run goes on after a stop or a crash, such as homing.",
    "finally": "Steps that run at the end in any case: success, failure and abort.",
    "outputs": "Named results of the whole run: name -> value or ${{ ... }}.",
    "Param.type": "What kind of value it is.",
    "unit": "The unit of a quantity, such as mm, s or uL.",
    "default": "The value where nothing is given; without it, one has to be given.",
    "minimum": "The lowest value allowed.",
    "maximum": "The highest value allowed.",
    "pattern": "A regular expression that a text has to fit.",
    "enum": "The only values allowed.",
    "Param.items": "The JSON Schema of each item of an array.",
    "id": "A name for the step; others read its result as ${{ steps.ID.field }}.",
    "name": "What people are shown instead of the id.",
    "when": "An expression; where it is false the step is skipped and its result is null.",
    "timeout": "After how long it is given up: for each attempt of a `do`, in total for other steps.",
    "Defaults.timeout": "The timeout of every `do` that has none of its own.",
    "retry": "How often (in total) what failed is tried: 3, or {attempts, wait, factor, ...}.",
    "background": "How many iterations of a loop may be unfinished while the next one runs.",
    "attempts": "How often in total; the first time counts.",
    "Retry.wait": "How long before the next attempt.",
    "factor": "By what the wait grows from attempt to attempt.",
    "max_wait": "The longest wait that `factor` may lead to.",
    "jitter": "A random share of the wait, from 0 to 1.",
    "on": "Only after these errors; the contract of the device names them.",
    "max_failed": "How many iterations may fail before the loop does.",
    "fallback": "Alternatives in order, each a step or a list of steps; the first that succeeds counts.",
    "on_error": "What a failure means in the end.",
    "on_unknown": "What to do where nobody knows whether a `once` action happened.",
    "on_failure": "What becomes of the other members when one fails.",
    "Do.with": "The parameters of the action.",
    "Use.with": "The parameters of the other protocol.",
    "Use.devices": "Its role -> our role; roles of the same name need not be said.",
    "mode": "background: the next step starts meanwhile; outside loops it is awaited at the end of the list.",
    "steps": "The steps inside.",
    "then": "The steps where it is true.",
    "else": "The steps where it is not.",
    "max": "How often at most; true after that is the failure MaxReached.",
    "key": "What identifies an iteration for ever, such as ${{ point.index }}.",
    "keep_going": "How many iterations may fail before the loop does; one that failed is a hole.",
    "collect": "One row of data.csv an iteration: column -> value or ${{ ... }}.",
    "choices": "What a person may answer.",
}
CHOICES = {
    "Param.type": {
        "quantity": "a number with a unit, such as 0.2 mm",
        "number": "a number without a unit",
        "integer": "a whole number",
        "string": "a text",
        "boolean": "true or false",
        "array": "a list",
    },
    "on_error": {
        "stop": "the run fails (as where nothing is said)",
        "continue": "the next step runs all the same",
        "pause": "the run waits for a person",
    },
    "on_unknown": {
        "probe": "ask the device, then a person (as where nothing is said)",
        "ask": "ask a person",
        "skip": "leave this iteration out",
        "repeat": "send it again: it may then happen twice",
    },
    "on_failure": {
        "finish": "the others go on to their end (as where nothing is said)",
        "cancel": "the others are stopped",
    },
    "mode": {"background": "the next step starts meanwhile"},
}


def words_for(model: type[BaseModel], key: str) -> str:
    """What a key of a model means; the keyword of a step means what its model says of itself."""
    if model in STEP_KINDS and key == getattr(model, "KIND", None):
        return about(model)
    return WORDS.get(f"{model.__name__}.{key}") or WORDS.get(key, "")


def choices_for(model: type[BaseModel], key: str) -> dict[str, str]:
    """What each choice of a key means."""
    return CHOICES.get(f"{model.__name__}.{key}") or CHOICES.get(key, {})


def about(model: type[BaseModel]) -> str:
    """What a model says of itself."""
    return inspect.getdoc(model) or ""
