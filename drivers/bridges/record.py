"""What the driver has sent of its `once` actions, on disk before it goes out.

For instruments without a memory of their own: after a crash the record says which goal was the last,
and whether its answer came. Where it did not, a count of the instrument's own (`count:`) may show it.
"""

import json
from pathlib import Path
from typing import Any

from ...system.files import write_whole

FILE = "once.json"
Values = dict[str, Any]


class OnceRecord:
    """`begun` is the goal that went out and whose end is not known; `done` the last that happened.

    One that is begun over another whose end is not known hides it only if it happens.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / FILE
        self._new = False
        self.done: Values | None = None
        self.begun: Values | None = None

    def open(self) -> None:
        """Read it, or begin it; raises OSError."""
        try:
            kept = json.loads(self._path.read_bytes())
            self.done, self.begun = kept["done"], kept["begun"]
        except FileNotFoundError:
            self._new = True
            self._write()
        except (ValueError, KeyError, TypeError) as fault:
            raise OSError(
                f"{self._path} is damaged, so what was sent is not known; move it away, and answer "
                f"what runs ask: {fault}"
            ) from fault

    def begin(self, goal: str, action: str, count: Values | None) -> None:
        """Before it goes out; raises OSError, and then it must not."""
        begun = {"goal": goal, "action": action, "count": count, "over": self.begun}
        before, self.begun = self.begun, begun
        try:
            self._write()
        except OSError:
            self.begun = before
            raise

    def ended(self, goal: str, happened: str, result: Values | None = None) -> None:
        """What is known of it now; `unknown` leaves it begun."""
        if self.begun is None or self.begun["goal"] != goal or happened == "unknown":
            return
        if happened == "yes":
            self.done = {"goal": goal, "result": result or {}}
        self.begun = self.begun.get("over") if happened == "no" else None
        self._write()

    def last(self) -> Values:
        """The probe's answer, if nothing is begun."""
        if self.done is None:  # a record that began with this server knows nothing of earlier ones
            return {"goal_id": None if self._new else ""}
        return {**self.done["result"], "goal_id": self.done["goal"]}

    def _write(self) -> None:
        write_whole(self._path, json.dumps({"done": self.done, "begun": self.begun}).encode())
