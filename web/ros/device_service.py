"""A pure action as a ROS service: asked, answered, nothing changed by it."""

from .device_action import DeviceAction
from .goals import Goals
from .kinds import ServiceKind
from .offer import Service, Values


class DeviceService(Service):
    """Calls the action of the same name and waits for it."""

    def __init__(self, name: str, kind: ServiceKind, action: DeviceAction, goals: Goals) -> None:
        self.name = name
        self.kind = kind
        self._action = action
        self._goals = goals

    async def answer(self, values: Values) -> Values:
        """The result; where it failed, its error fields say so. Raises Refused."""
        goal = await self._goals.begin(self._action, values, lambda feedback: None)
        return (await goal.end()).result
