"""Which attempts of earlier engine sessions bear on an action that is to be done now.

A run that was resumed, whose protocol was changed, or whose device was touched, comes to actions
that were done before: each counts as done, is asked about, is done again, or must not be.
"""

from dataclasses import dataclass
from typing import Any

from ....schemas.contract import Action
from ...dispatch.probe import told_before, unknown_path, what_it_proves
from ...journal.past import PastGoal
from ...lab.bind import BoundRole
from ...language.operators import words
from ...run.questions import DID_NOT_HAPPEN
from ...run.run import Run


@dataclass(frozen=True, slots=True)
class EarlierAttempts:
    """The rules for one action of one device."""

    run: Run
    role: BoundRole
    action: Action

    def attempt(self, path: str, attempt: int) -> PastGoal | None:
        """What was done as this attempt; in a comparison what has succeeded, whenever it was."""
        past = self.run.past
        found = past.newest_success(path) if past.comparing else None
        return found or past.goal(path, attempt)

    def is_behind(self, past: PastGoal, wanted: str) -> bool:
        """True for an earlier attempt that has no bearing on this one, which means `wanted`."""
        if past.ended is None or self.run.past.comparing:
            return False
        once = self.action.effect == "once"
        if past.sent.means != wanted:  # the protocol was changed since
            return not once or self._happened(past) == "no"
        if past.succeeded:
            return not once and self.run.history.is_stale(past) and not self._is_of_before(past)
        if once and (happened := self._happened(past)) != "no":
            # Unknown, or it did happen: never simply sent again, unless a probe or a person says it did not.
            return past.spent and happened == "unknown" and self._was_denied(past)
        return past.spent

    def others_came(self, past: PastGoal, strand: str) -> bool:
        """True for what was set on a device that something beside it has used since this tree began."""
        once = self.action.effect == "once"
        if not past.succeeded or once or self._is_of_before(past) or self.run.past.comparing:
            return False
        return self.run.strands.since(past.sent.device, past.state_n, strand)

    def must_not_be_done_anew(self, past: PastGoal, wanted: str) -> bool:
        """A finished `once` action that differs in a changed protocol: the run cannot continue.

        Under the same protocol only the values it was computed from have changed (a balance was read
        again): then it is done.
        """
        done = self.run.past
        changed = done.changed is not None and past.sent.n < done.changed.n
        return changed and past.sent.means != wanted and not done.comparing

    def _is_of_before(self, past: PastGoal) -> bool:
        """True for what was read before something `once` was begun: it cannot be read again.

        The empty pan was weighed, then something was dispensed on it.
        """
        return self.action.effect == "pure" and self.run.history.once_n > past.state_n

    def _happened(self, past: PastGoal) -> str:
        error = past.ended.error if past.ended is not None else None
        if error is None:
            return "yes" if past.succeeded else "unknown"
        return error.happened if error.happened != "unknown" else self.action.happened(error.name)

    def _was_denied(self, past: PastGoal) -> bool:
        history, goal_id = self.run.history, past.sent.id
        answer = history.past.answers.get(unknown_path(goal_id))
        if answer is not None and answer.choice == DID_NOT_HAPPEN:
            return True
        return what_it_proves(history, self.role, goal_id, told_before(history, goal_id)) is False


def changed_words(past: PastGoal, wanted: dict[str, Any]) -> str:
    """What a person reads who has changed an action that cannot be done a second time."""
    was, now = (
        ", ".join(f"{n} {words(v)}" for n, v in p.items()) for p in (past.sent.params, wanted)
    )
    return (
        f"it was done with {was or 'nothing'}, but the protocol now asks for {now or 'nothing'}; "
        "it will not be done a second time"
    )
