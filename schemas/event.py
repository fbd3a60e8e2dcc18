"""The events of a run, for the terminal, `--json` and the page."""

from typing import Any, Literal

from pydantic import Field

from .model import Model

EventKind = Literal[
    "run", "phase", "step", "goal", "feedback", "iteration", "question", "answer", "log",
    "control", "safe", "report", "finished",
]  # fmt: skip


class Event(Model):
    """One thing that happened, at a path of the run."""

    event: EventKind
    at: str = ""
    path: str = ""
    state: str = ""
    text: str = ""
    data: dict[str, Any] = Field(default_factory=dict)
