"""What happens if a step fails, in sentences that follow it."""

from collections.abc import Iterator
from typing import Any

from ....schemas import protocol as p
from ..english import bare, count_of, joined

UNKNOWN_FATE = {
    "probe": "the device is asked, and a person if it does not know",
    "ask": "a person is asked",
    "skip": "it counts as failed and is not repeated",
    "repeat": "it is repeated",
}


def limit_text(step: p.StepBase) -> str:
    """` (30 s at most)`: the time that a step has; that of `defaults` is stated once for all."""
    return f" ({duration(step.timeout)} at most)" if step.timeout is not None else ""


def duration(limit: Any) -> str:
    """`30 s`; a bare number is in seconds."""
    return f"{limit:g} s" if isinstance(limit, int | float) else bare(limit)


def retry_sentence(said: int | p.Retry | None, what: str = "it") -> str:
    """`If that fails, it is tried up to 3 times in all, 1 s apart.`"""
    if said is None or (isinstance(said, int) and said < 2):
        return ""
    if isinstance(said, int):
        return f"If that fails, {what} is tried up to {count_of(said, 'time')} in all."
    if said.attempts < 2:
        return ""
    by = f" with {joined(said.on, 'or')}" if said.on else ""
    return f"If that fails{by}, {what} is tried up to {said.attempts} times in all{_apart(said)}."


def _apart(said: p.Retry) -> str:
    if said.wait in (0, "0 s"):
        return ""
    text = f", {duration(said.wait)} apart"
    if said.factor != 1:
        text += f" and {said.factor:g} times as long after each try"
        if said.max_wait is not None:
            text += f", {duration(said.max_wait)} at most"
    return text


def last_sentences(step: p.StepBase) -> Iterator[str]:
    """What applies when retries and alternatives are used up, if the step states it."""
    if step.on_unknown is not None:
        yield f"If it is not known whether it happened, {UNKNOWN_FATE[step.on_unknown]}."
    if step.on_error == "continue":
        yield "If it fails for good, the run continues anyway."
    elif step.on_error == "pause":
        yield "If it fails for good, the run pauses until a person continues it."
    if isinstance(step, p.Parallel) and step.on_failure == "cancel":
        yield "As soon as one of them fails, the others are cancelled."
