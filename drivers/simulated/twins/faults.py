"""Injected faults: make an action fail with an error of its contract, at the configured rate.

    faults:
      measure: {ButtonNotFound: 0.02, DialogOpen: 0.005}
      export: 0.05                     # any of the errors that the contract names

Whether a goal fails depends only on the seed and the goal's id, so a run with the same ids meets
the same faults however often its servers are killed, and a retry (another id) is drawn again.
"""

from hashlib import blake2b
from typing import Any

from ....schemas.contract import Contract, Happened
from ...driver import ActionFailed


def chance(*about: object) -> float:
    """A number in 0..1 that is always the same for the same things."""
    digest = blake2b("\x1f".join(map(str, about)).encode(), digest_size=8).digest()
    return int.from_bytes(digest) / 2**64


class Faults:
    """The injected faults of one device; raises ValueError if the contract does not have them."""

    def __init__(self, ordered: dict[str, Any], contract: Contract, seed: int) -> None:
        self.contract = contract
        self.seed = seed
        self.rates = {action: self._rates(action, rate) for action, rate in ordered.items()}

    def _rates(self, action: str, ordered: Any) -> dict[str, float]:
        if action not in self.contract.actions:
            raise ValueError(f"faults: {self.contract.type} has no action {action!r}")
        known = self.contract.actions[action].errors
        if not isinstance(ordered, dict):
            ordered = {error: float(ordered) / len(known) for error in known}
        if unknown := sorted(set(ordered) - set(known)) or ([] if known else ["any"]):
            raise ValueError(
                f"faults: {action} of {self.contract.type} cannot fail with {', '.join(unknown)}; "
                f"its errors are: {', '.join(known) or 'none'}"
            )
        for error, rate in ordered.items():
            if not 0 <= float(rate) <= 1:
                raise ValueError(f"faults: {action}.{error} is {rate}; a probability is 0 to 1")
        return {error: float(rate) for error, rate in ordered.items()}

    def drawn(self, action: str, goal_id: str) -> "Fault | None":
        """The fault that this goal meets, if it meets one."""
        luck = chance(self.seed, action, goal_id)
        for error, rate in self.rates.get(action, {}).items():
            if luck < rate:
                happened = self.contract.actions[action].happened(error)
                return Fault(error, action, happened, chance(self.seed, action, goal_id, error))
            luck -= rate
        return None


class Fault:
    """One fault: before the action, after it, or unknown which."""

    def __init__(self, error: str, action: str, happened: Happened, coin: float) -> None:
        self.error = error
        self.action = action
        self.after = happened == "yes" or (happened == "unknown" and coin < 0.5)

    def failure(self) -> ActionFailed:
        return ActionFailed(self.error, f"injected fault in {self.action} (simulated)")
