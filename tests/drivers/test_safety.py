"""Who asks for the safe state gets one true answer, even where the driver hangs or raises."""

import asyncio

from labrun.drivers.driver import Driver
from labrun.drivers.safety import Safety
from labrun.schemas.contract import Contract

CONTRACT = Contract(type="lamp@1", safe_state=["dim", "off"], actions={"dim": {}, "off": {}})


class Lamp(Driver):
    def __init__(self):
        self.did = []

    async def dim(self, goal):
        self.did.append("dim")
        return {}

    async def off(self, goal):
        self.did.append("off")
        return {}


def test_without_a_safe_of_its_own_the_contracts_actions_are_done_in_order():
    lamp = Lamp()
    answer = asyncio.run(confirmed(lamp))

    assert answer == (True, "lamp is in its safe state")
    assert lamp.did == ["dim", "off"]


def test_a_driver_that_raises_is_not_safe():
    class Broken(Lamp):
        async def safe(self):
            raise OSError("cable out")

    assert asyncio.run(confirmed(Broken())) == (False, "lamp may not be safe: OSError: cable out")


def test_who_asks_while_it_is_under_way_shares_the_answer():
    class Slow(Lamp):
        async def safe(self):
            self.did.append("safe")
            await asyncio.sleep(0.2)

    async def story():
        lamp = Slow()
        safety = Safety("lamp", lamp, CONTRACT, lambda: None)
        answers = await asyncio.gather(safety.confirmed(0.01), safety.confirmed(10))
        return lamp.did, answers

    did, (hasty, patient) = asyncio.run(story())

    assert did == ["safe"]
    assert hasty == (False, "lamp did not confirm its safe state within 0.01 s")
    assert patient[0]


async def confirmed(lamp):
    return await Safety("lamp", lamp, CONTRACT, lambda: None).confirmed(10)
