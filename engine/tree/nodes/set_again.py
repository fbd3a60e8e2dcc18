"""What finished iterations had set on a device that was touched since is set again."""

from collections import deque
from typing import Any

from ...dispatch.dispatcher import Dispatcher
from ...dispatch.request import Request
from ...journal.past import PastGoal
from ...language.value import Constant
from ...run.frame import Scope
from ...run.run import Run
from .action import ActionLeaf, ActionPlan


class SetAgain(ActionLeaf):
    """One action, requested as it was when it had set something; `past` is that goal."""

    def __init__(
        self, run: Run, scope: Scope, dispatcher: Dispatcher, plan: ActionPlan, past: PastGoal
    ) -> None:
        super().__init__(run, scope, dispatcher, plan)
        self.past = past

    def _arguments(self) -> dict[str, Any]:
        return dict(self.past.sent.params)

    def _do(self, request: Request) -> None:
        self.repeating = self.replaying  # also there: it was done, if under another path
        self.dispatcher.request(request)


def settings_of(
    run: Run, scope: Scope, dispatcher: Dispatcher, segment: str, loop: str
) -> deque[SetAgain]:
    """What the finished iterations of a loop had set and may be lost by now, in the old order.

    Has to be asked before the loop is entered again, once for each tree.
    """
    kept = run.past.settings.pop(loop, {}).values()
    leaves: deque[SetAgain] = deque()
    for past in sorted(kept, key=lambda past: past.sent.n):
        sent = past.sent
        role = next((role for role in run.roles.values() if role.device == sent.device), None)
        if role is None or not run.history.is_stale(past) or run.history.is_replaced(past):
            continue
        action = role.contract.actions.get(sent.action)
        if action is None or not action.sets:
            continue  # another protocol, or another contract, by now
        # Beside the loop, not in it: no iteration has such a path.
        plan = ActionPlan(
            f"{segment}:again:{sent.n}", role, sent.action, action, Constant(sent.params), None
        )
        leaves.append(SetAgain(run, scope, dispatcher, plan, past))
    return leaves
