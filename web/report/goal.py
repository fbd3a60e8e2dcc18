"""One goal under way, and the incident that it becomes unless it simply succeeds."""

from ...engine.journal.course import Goal
from ...schemas import journal as j
from .formatting import duration, seconds_between
from .incident import Incident


def failed_goal(goal: Goal, record: j.GoalEnded, session: int) -> Incident:
    """A goal that was aborted or cancelled; past its timeout in the same session, it is a timeout."""
    error = record.error
    name = error.name if error is not None else "Canceled"
    message = error.message if error is not None else ""
    happened = error.happened if error is not None else ""
    took_s = seconds_between(goal.record.at, record.at)
    limit_s = goal.record.timeout_s
    expired = limit_s is not None and took_s >= limit_s and goal.session == session
    if record.state == "CANCELED" and limit_s is not None and expired:
        name = "Timeout"
        message = f"cancelled after {duration(took_s)}; its timeout is {duration(limit_s)}"
    once = goal.record.effect == "once" and happened == "unknown"
    return Incident(
        at=record.at, path=goal.path, attempt=goal.attempt, label=goal.record.label, error=name,
        message=message, happened=happened,
        failed=(record.state == "ABORTED" and name != "Stopped") or name == "Timeout",
        doubt="it was unknown whether it had happened" if once else "", life=goal.session, n=record.n,
    )  # fmt: skip


def lost_goal(goal: Goal, record: j.Record) -> Incident:
    """A goal whose end never reached the engine, which continued without it."""
    return Incident(
        at=record.at or goal.record.at, path=goal.path, attempt=goal.attempt, label=goal.record.label,
        error="Lost", message="its server remained unreachable; the journal has no end for it",
        happened="unknown", doubt="its server remained unreachable", life=goal.session,
        n=record.n or goal.record.n,
    )  # fmt: skip


def goal_in_flight(goal: Goal) -> Incident:
    """A goal that was under way when its engine ended: not a failure, outcome not known yet."""
    return Incident(
        at=goal.record.at, path=goal.path, attempt=goal.attempt, label=goal.record.label, error="",
        message="", failed=False, doubt=f"under way when engine {goal.session} ended",
        life=goal.session, n=goal.record.n,
    )  # fmt: skip
