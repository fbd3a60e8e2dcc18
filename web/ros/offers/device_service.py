"""A pure action as a ROS service: it changes nothing."""

from ..interfaces.kinds import ServiceKind
from .device_action import DeviceAction
from .goals import Goals
from .offer import Service, Values


class DeviceService(Service):
    """Calls the action of the same name and waits for it."""

    def __init__(self, name: str, kind: ServiceKind, action: DeviceAction, goals: Goals) -> None:
        self.name = name
        self.kind = kind
        self._action = action
        self._goals = goals

    async def answer(self, values: Values) -> Values:
        """The result; its error fields report a failure. Raises Refused."""
        goal = await self._goals.begin(self._action, values, lambda feedback: None)
        return (await goal.end()).result
