"""What the paper's names share: the zero of the axes, the last shot, the last spectrum."""

import json
from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..device_action import DeviceAction
from ..goals import aborted, result_of
from ..kinds import ActionKind
from ..offer import Action, End, Refused, Values, Work

if TYPE_CHECKING:
    from ..site import Site

AXES = ("x", "y", "z")


class Paper:
    """Kept for as long as the lab is served; the zero is kept beyond that."""

    def __init__(self, site: "Site") -> None:
        self.site = site
        self.shot: str | None = None
        self.file: str | None = None
        self._path = site.folders.state / "zero.json"
        self._zeros: dict[str, dict[str, float]] = self._read()
        self._moved: list[Callable[[], None]] = []

    def action(self, device: str, name: str) -> DeviceAction:
        """An action of a device."""
        return self.site.actions_of(device)[name]

    def status(self, device: str) -> Values:
        """What a device said last, as its contract has it."""
        return self.site.statuses.get(device, {})

    def zero(self, device: str) -> dict[str, float]:
        """Where the zero of each axis is, in mm of the bench."""
        return {**dict.fromkeys(AXES, 0.0), **self._zeros.get(device, {})}

    def set_zero(self, device: str, axes: dict[str, float]) -> None:
        """Count the axes from these places; raises OSError."""
        self._zeros[device] = {**self.zero(device), **axes}
        self._path.write_text(json.dumps(self._zeros), encoding="utf-8")
        for moved in self._moved:
            moved()

    def on_zero(self, moved: Callable[[], None]) -> None:
        """Be told when a zero was set."""
        self._moved.append(moved)

    def _read(self) -> dict[str, dict[str, float]]:
        try:
            return json.loads(self._path.read_bytes())
        except (OSError, ValueError):
            return {}


class PaperAction(Action):
    """An action of the paper, done by one or more actions of ours; words of its own in the result."""

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
        """The same work for an action of ours: its feedback in the paper's words."""
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
            return aborted(action, "Rejected", str(fault), "no")  # some of the goal is done already

    def ended(self, end: End, words: str = "success", **data: Any) -> End:
        """The end in the paper's terms: `msg` is `success`, or what went wrong."""
        failed = [end.result.get("error_name"), end.result.get("error_message")]
        said = words if end.state == "SUCCEEDED" else ": ".join(str(one) for one in failed if one)
        return End(end.state, result_of(self, {"msg": said, **data}))
