"""How reports on goals are sent: empty fields are left out, an error is always complete."""

from collections.abc import Callable
from typing import Any

from ...schemas.messages import GoalReport

Tell = Callable[[str, dict[str, Any], set[str]], None]
"""Send an event with its payload; the set holds the sessions that also get the files."""


def wire(report: GoalReport) -> dict[str, Any]:
    """A report as the payload of an `update`, an acknowledgement or an answer to `query`."""
    told: dict[str, Any] = {
        "id": report.id,
        "state": report.state,
        "seq": report.seq,
        "boot": report.boot,
    }
    if report.progress is not None:
        told["progress"] = report.progress
    if report.message:
        told["message"] = report.message
    if report.result is not None:
        told["result"] = report.result
    if report.error is not None:
        told["error"] = report.error.model_dump()
    if report.files:
        told["files"] = {name: file.model_dump() for name, file in report.files.items()}
    return told
