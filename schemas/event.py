"""The events of a run, for the terminal, `--json` and the page."""

from typing import Any, Literal, get_args

from pydantic import Field

from .model import Model

EventKind = Literal[
    "run", "phase", "step", "goal", "feedback", "iteration", "question", "answer", "log",
    "control", "safe", "report", "finished",
]  # fmt: skip
KINDS: frozenset[EventKind] = frozenset(get_args(EventKind))


class Event(Model):
    """One thing that happened, at a path of the run."""

    event: EventKind
    at: str = ""
    path: str = ""
    state: str = ""
    text: str = ""
    data: dict[str, Any] = Field(default_factory=dict)
