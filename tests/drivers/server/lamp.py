"""A lamp whose every act is recorded, on a device of its own: no socket, no disk, virtual time."""

import asyncio
from pathlib import Path

from labrun.drivers.driver import ActionCanceled, Driver, Place
from labrun.drivers.server.device import ServedDevice
from labrun.drivers.server.ledger import Ledger
from labrun.engine.run.virtual_time import VirtualLoop
from labrun.schemas.contract import Contract
from labrun.schemas.messages import ENDED, Goal, LeaseRequest

LAST_ACT_S = 0.7
"""How long after a cancel the lamp is switched once more."""
SAFE_S = 1.1


class Lamp(Driver):
    """Shines until it is told not to, and is switched on once more after a cancel."""

    contract = "lamp@1"

    def __init__(self, place):
        super().__init__(place)
        self.acts = []
        self.lit = False
        self.ends = {}

    async def shine(self, goal):
        self.acts.append(("begins", goal.id))
        self.lit = True
        self.ends[goal.id] = end = asyncio.Event()
        ends = [asyncio.ensure_future(e.wait()) for e in (end, goal.cancelled)]
        try:
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
            if not end.is_set():
                await asyncio.sleep(LAST_ACT_S)
                self.lit = True
                raise ActionCanceled
            return {}
        finally:
            for one in ends:
                one.cancel()
            del self.ends[goal.id]
            self.acts.append(("over", goal.id))

    async def safe(self):
        self.acts.append(("safe", ""))
        self.lit = False
        await asyncio.sleep(SAFE_S)
        self.acts.append(("safe over", ""))


class Story:
    """The lamp's device as its server has it, and what was told about its goals."""

    def __init__(self, driver=Lamp, ledger=None, **contract):
        model = Contract.model_validate(
            {"type": "lamp@1", "actions": {"shine": {"cancel": True}}, **contract}
        )
        place = Place("lamp", {}, {}, Path(), Path(), model)
        self.lamp = driver(place)
        self.ledger = ledger or Ledger(Path(":memory:"))
        self.told = []
        self.device = ServedDevice(place, self.lamp, model, self.ledger, self._tell)
        self._goals = 0

    def _tell(self, event, payload, followers):
        if event == "update" and payload["state"] in ENDED:
            self.told.append((payload["id"], payload["state"]))

    async def take(self, owner="run-1", ttl_s=1000.0, **more):
        request = LeaseRequest(device="lamp", owner=owner, ttl_s=ttl_s, **more)
        return await self.device.take_lease(request, owner)

    async def goal(self, epoch=None, name=None):
        self._goals += 1
        name = name or f"g{self._goals}"
        epoch = self.device.lease.holder.epoch if epoch is None else epoch
        boot = self.ledger.boot
        goal = Goal(id=name, device="lamp", boot=boot, epoch=epoch, action="shine")
        await self.device.accept(goal, "s", self.device.stops)
        return name

    async def until(self, *act):
        async with asyncio.timeout(1000):
            while act not in self.lamp.acts:  # noqa: ASYNC110 - the acts are a list
                await asyncio.sleep(0.1)

    @classmethod
    def tell(cls, told, **options):
        """Tell a story in virtual time, from the opening of the device to its close."""

        async def whole():
            story = cls(**options)
            await story.device.open(make_safe=False)
            try:
                return await told(story)
            finally:
                await story.device.wind_down()
                await story.device.close()
                story.ledger.close()

        with asyncio.Runner(loop_factory=VirtualLoop) as runner:
            return runner.run(whole())
