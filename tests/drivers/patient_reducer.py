"""The reducer on a spectrum that takes its time: none of real size can be caught in its middle."""

import asyncio
from dataclasses import replace

from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.reducer import Reducer


class PatientReducer(Reducer):
    """Waits `pause` seconds, then reduces."""

    def __init__(self, place: Place) -> None:
        super().__init__(replace(place, config={}))  # the reducer's own has no keys
        self.pause_s = float(place.config.get("pause", 0))

    async def reduce(self, goal: GoalContext, **params):
        await asyncio.sleep(self.pause_s)
        return await super().reduce(goal, **params)
