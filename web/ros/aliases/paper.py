"""State shared by the paper's names: the zero of the axes, the last shot, the last spectrum."""

import json
from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..interfaces.kinds import ActionKind
from ..offers.device_action import DeviceAction
from ..offers.goals import aborted, result_of
from ..offers.offer import Action, End, Refused, Values, Work

if TYPE_CHECKING:
    from ..offers.offered_lab import OfferedLab

AXES = ("x", "y", "z")


class Paper:
    """Kept while the lab is served; the zero is kept beyond that."""

    def __init__(self, lab: "OfferedLab") -> None:
        self.offered = lab
        self.shot: str | None = None
        self.file: str | None = None
        self._path = lab.folders.state / "zero.json"
        self._zeros: dict[str, dict[str, float]] = self._read()
        self._moved: list[Callable[[], None]] = []

    def action(self, device: str, name: str) -> DeviceAction:
        """An action of a device."""
        return self.offered.actions_of(device)[name]

    def status(self, device: str) -> Values:
        """A device's last status, as in its contract."""
        return self.offered.statuses.get(device, {})

    def zero(self, device: str) -> dict[str, float]:
        """The zero of each axis, in mm of the bench."""
        return {**dict.fromkeys(AXES, 0.0), **self._zeros.get(device, {})}

    def set_zero(self, device: str, axes: dict[str, float]) -> None:
        """Set the zeros of axes; raises OSError."""
        self._zeros[device] = {**self.zero(device), **axes}
        self._path.write_text(json.dumps(self._zeros), encoding="utf-8")
        for moved in self._moved:
            moved()

    def on_zero(self, moved: Callable[[], None]) -> None:
        """Call `hear` when a zero is set."""
        self._moved.append(moved)

    def _read(self) -> dict[str, dict[str, float]]:
        try:
            return json.loads(self._path.read_bytes())
        except (OSError, ValueError):
            return {}


class PaperAction(Action):
    """An action of the paper, done by one or more of our actions; its result has its own fields."""

    said: str
    """The one field of its feedback."""

    def __init__(self, paper: Paper, name: str, device: str, kind: ActionKind) -> None:
        self.paper = paper
        self.name = name
        self.device = device
        self.kind = kind

    @abstractmethod
    async def carry(self, work: Work) -> End: ...

    def part(self, work: Work) -> Work:
        """The same goal for one of our actions: its feedback in the paper's terms."""
        return Work(
            work.id,
            {},
            lambda told: work.tell({self.said: told["message"]}),
            work.begun,
            work.cancelled,
        )

    async def done(
        self, action: DeviceAction, params: dict[str, Any], work: Work, part: int = 1
    ) -> End:
        """One of our actions; the end is in our own terms."""
        inner = self.part(work)
        try:
            outcome = await action.sent(action.checked(params), inner, part)
            return action.ending(outcome, inner)
        except Refused as fault:
            if part == 1:
                raise
            return aborted(action, "Rejected", str(fault), "no")  # part of the goal is already done

    def ended(self, end: End, words: str = "success", **data: Any) -> End:
        """The end in the paper's terms: `msg` is `success`, or what went wrong."""
        failed = [end.result.get("error_name"), end.result.get("error_message")]
        said = words if end.state == "SUCCEEDED" else ": ".join(str(one) for one in failed if one)
        return End(end.state, result_of(self, {"msg": said, **data}))
