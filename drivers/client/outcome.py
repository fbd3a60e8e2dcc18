"""How a goal ended, as far as can be known."""

from dataclasses import dataclass, field
from typing import Any, Literal

from ...schemas.contract import Happened
from ...schemas.messages import FileContent, GoalError, GoalReport

OutcomeState = Literal["SUCCEEDED", "CANCELED", "ABORTED", "LOST"]


@dataclass(frozen=True, slots=True)
class Outcome:
    """The end of a goal; LOST if the server stayed unreachable, so that the end is unknown."""

    state: OutcomeState
    result: dict[str, Any] | None = None
    error: GoalError | None = None
    files: dict[str, FileContent] = field(default_factory=dict)
    boot: str = ""


LEDGER_WORDS = ("INTERRUPTED", "NEVER_STARTED")
"""What a server reports for goals whose end it has not seen itself."""


def outcome_of(report: GoalReport) -> Outcome:
    """The outcome given by a server's last report on a goal."""
    error = report.error
    if error is not None and report.state == "ABORTED" and error.name in LEDGER_WORDS:
        error = error.model_copy(update={"name": "Lost"})
    state: Any = report.state  # only called for reports of goals that have ended
    return Outcome(state, report.result, error, report.files, report.boot)


def refused(code: str, message: str, boot: str) -> Outcome:
    """The outcome of a goal that the server refused: it certainly did not happen."""
    name = {"BUSY": "Busy", "STOPPED": "Stopped"}.get(code, "Rejected")
    return Outcome("ABORTED", error=GoalError(name=name, message=message, happened="no"), boot=boot)


def lost(message: str, happened: Happened, boot: str = "") -> Outcome:
    """The outcome of a goal that its server knows nothing about."""
    return Outcome(
        "ABORTED", error=GoalError(name="Lost", message=message, happened=happened), boot=boot
    )


def out_of_reach(message: str) -> Outcome:
    """The outcome of a goal whose server was unreachable for too long."""
    return Outcome("LOST", error=GoalError(name="Lost", message=message, happened="unknown"))
