"""Optimizers that take their time: none can otherwise be caught in the middle."""

import asyncio
from dataclasses import replace

from labrun.drivers.driver import Place
from labrun.drivers.optimizer.gp import Gp


class PatientGp(Gp):
    """Waits `pause` seconds before it asks, tells or answers."""

    def __init__(self, place: Place) -> None:
        super().__init__(replace(place, config={}))
        self.pause_s = float(place.config.get("pause", 0))

    async def ask(self, goal, **params):
        await asyncio.sleep(self.pause_s)
        return await super().ask(goal, **params)

    async def tell(self, goal, **params):
        await asyncio.sleep(self.pause_s)
        return await super().tell(goal, **params)
