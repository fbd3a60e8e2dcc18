"""State shared by the paper's names: the zero of the axes, the last shot, the last spectrum."""

import asyncio
import json
import logging
from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..offers.device_action import DeviceAction
from ..offers.goals import aborted, result_of
from ..offers.offer import Action, End, Refused, Service, Values, Work

if TYPE_CHECKING:
    from ..offers.offered_lab import OfferedLab

AXES = ("x", "y", "z")
TOLD_S = 0.5
"""How often the paper's topics are told, besides on change."""
LOG = logging.getLogger(__name__)


class Paper:
    """Kept while the lab is served; the zero is kept beyond that."""

    def __init__(self, lab: "OfferedLab") -> None:
        self.offered = lab
        self.shot: str | None = None
        self.file: str | None = None
        self._path = lab.folders.state / "zero.json"
        self._zeros: dict[str, dict[str, float]] = self._read()
        self._topics: list[Callable[[], None]] = []

    def action(self, device: str, name: str) -> DeviceAction:
        """An action of a device."""
        return self.offered.actions_of(device)[name]

    def status(self, device: str) -> Values:
        """A device's last status, as in its contract."""
        return self.offered.statuses.get(device, {})

    async def status_from_now(self, device: str) -> Values:
        """A status that the device was asked for after this call; raises Refused.

        The first that comes may have been asked for before, during a move that has ended since.
        """
        told: asyncio.Queue[Values] = asyncio.Queue()
        patience_s = self.offered.lab.lab.start_timeout_s
        unheard = self.offered.on_status(device, told.put_nowait)
        try:
            async with asyncio.timeout(patience_s):
                await told.get()
                return await told.get()
        except TimeoutError:
            raise Refused(f"{device} did not report its status within {patience_s:g} s") from None
        finally:
            unheard()

    def zero(self, device: str) -> dict[str, float]:
        """The zero of each axis, in mm of the bench."""
        return {**dict.fromkeys(AXES, 0.0), **self._zeros.get(device, {})}

    def set_zero(self, device: str, axes: dict[str, float]) -> None:
        """Set the zeros of axes; raises OSError."""
        self._zeros[device] = {**self.zero(device), **axes}
        self._path.write_text(json.dumps(self._zeros), encoding="utf-8")
        self.tell()

    def tells(self, topic: Callable[[], None]) -> None:
        """Call this twice a second, and when a zero is set."""
        self._topics.append(topic)

    def tell(self) -> None:
        """Tell every topic of the paper."""
        for topic in self._topics:
            topic()

    async def tell_often(self) -> None:
        """Tell them twice a second, for ever, as the paper's nodes do."""
        while True:
            await asyncio.sleep(TOLD_S)
            self.tell()

    def online(self, device: str) -> bool:
        """Whether the device's server answers."""
        return self.offered.devices[device].online

    def busy(self, device: str) -> bool:
        """Whether a goal of ROS is under way on the device."""
        goals, actions = self.offered.goals, self.offered.offers.actions.values()
        return any(
            goal.ended is None
            for action in actions
            if device_of(action) == device
            for goal in goals.of(action)
        )

    def _read(self) -> dict[str, dict[str, float]]:
        try:
            return json.loads(self._path.read_bytes())
        except (OSError, ValueError):
            return {}


def device_of(action: Action) -> str | None:
    """The device that an action is for."""
    if isinstance(action, DeviceAction):
        return action.device.name
    return action.device if isinstance(action, PaperAction) else None


class PaperAction(Action):
    """An action of the paper, done by one or more of our actions.

    Its types have no field for why a goal failed: the last feedback says it, and the log.
    """

    can_cancel = False
    said = "feedback"
    """The one field of its feedback."""

    def __init__(self, paper: Paper, name: str, device: str) -> None:
        self.paper, self.name, self.device = paper, name, device

    @classmethod
    def add(cls, paper: Paper, name: str, device: str) -> None:
        """Offer it."""
        paper.offered.offers.actions[name] = cls(paper, name, device)

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

    def ended(self, work: Work, end: End, words: str = "success", **data: Any) -> End:
        """The end in the paper's terms: `words`, or what went wrong, is its last feedback."""
        failed = [end.result.get("error_name"), end.result.get("error_message")]
        said = words if end.state == "SUCCEEDED" else ": ".join(str(one) for one in failed if one)
        if end.state == "ABORTED":
            LOG.warning("%s: a goal is aborted: %s", self.name, said)
        work.tell({self.said: said})
        return End(end.state, result_of(self, {"msg": said, **data}))


class PaperService(Service):
    """A service of the paper about one device."""

    def __init__(self, paper: Paper, name: str, device: str) -> None:
        self.paper, self.name, self.device = paper, name, device

    @classmethod
    def add(cls, paper: Paper, name: str, device: str) -> None:
        """Offer it."""
        paper.offered.offers.services[name] = cls(paper, name, device)
