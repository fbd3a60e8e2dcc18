"""One action on its way: requested by a leaf of the tree, carried out by the dispatcher."""

import json
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

from ...drivers.client.client import Outcome
from ...schemas.contract import Action
from ...schemas.messages import GoalError
from ..journal.past import PastGoal
from ..lab.bind import BoundRole
from ..run.reservations import Reservation

SORTED = json.JSONEncoder(sort_keys=True)
CANCELED_BEFORE_SENDING = Outcome(
    state="CANCELED",
    result=None,
    error=GoalError(name="Canceled", message="withdrawn before it was sent", happened="no"),
    files={},
    boot="",
)


@dataclass(slots=True, eq=False)
class Request:
    """An attempt at one action; `outcome` is None until it is over.

    `within`: the path of the iteration, or the phase, that it belongs to. `epoch`: that of the lease
    under which it was sent. `adopt`: the goal of an earlier engine session that is asked about under
    its own id. `doubted`: nobody knows whether it was sent before, so it is only asked about, too.
    `cut`: it was ended by a stop, so it has no outcome: what asked for it waits.
    `urgent`: it is sent also while the run is paused. `reservation`: what it belongs to; `strand`: of what
    runs beside other things it is part; `asked`: its place in the order of asking.
    """

    goal_id: str
    path: str
    role: BoundRole
    action_name: str
    action: Action
    params: dict[str, Any]
    timeout_s: float | None
    within: str = ""
    epoch: int = 0
    adopt: PastGoal | None = None
    doubted: bool = False
    outcome: Outcome | None = None
    sent_at: float | None = None
    canceled_at: float | None = None
    expired: bool = False
    withdrawn: bool = False
    cut: bool = False
    urgent: bool = False
    reservation: Reservation | None = None
    strand: str = ""
    asked: int = 0

    @property
    def device(self) -> str:
        """The lab's device that does it."""
        return self.role.device

    @property
    def exclusive(self) -> bool:
        """Whether its device does nothing else meanwhile."""
        return not (self.role.contract.concurrent or self.action.meanwhile)

    @property
    def label(self) -> str:
        """`gantry.move_to`, as people name it."""
        return f"{self.role.role}.{self.action_name}"

    def means(self) -> str:
        """A hash of what is requested: if it is equal, finished work counts as done."""
        return means(self.role, self.action_name, self.params)


def means(role: BoundRole, action_name: str, params: dict[str, Any]) -> str:
    """The hash over contract, role, action and resolved parameters that the journal keeps."""
    what = [role.contract.type, role.role, action_name, params]
    return sha256(SORTED.encode(what).encode()).hexdigest()[:16]


def outcome_of(past: PastGoal) -> Outcome:
    """The outcome of a goal of an earlier engine session, from the journal."""
    assert past.ended is not None
    return Outcome(
        state=past.ended.state, result=past.ended.result, error=past.ended.error, files={},
        boot=past.sent.boot,
    )  # fmt: skip
