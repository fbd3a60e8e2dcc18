"""One action by hand at a time: of two requests at the same instant, one is refused."""

import asyncio
import time
from contextlib import asynccontextmanager

import pytest

from labrun.engine.lab.lab import load_lab
from labrun.web.access.headers import Deadline
from labrun.web.devices.acting import Acting
from labrun.web.devices.arming import Arming
from labrun.web.devices.devices import DeviceLinks
from labrun.web.devices.jogging import Jogging
from labrun.web.devices.where import where_mm
from labrun.web.local.lab_here import lab_here
from labrun.web.local.refusal import Refusal
from labrun.web.models.devices import CallAction, JogStart

LAB = """\
name: small
simulated: true
devices:
  gantry: {contract: gantry@1, driver: sim_gantry, config: {clock: fast, homed: true}}
"""


class Bench:
    """A gantry served from here, without the page around it."""

    def __init__(self, folder, clock="fast", least_s=120):
        (folder / "lab.yaml").write_text(LAB.replace("fast", str(clock)))
        lab = lab_here(load_lab(folder / "lab.yaml")[0], folder / "bench")
        self.seen = asyncio.Event()
        self.links = DeviceLinks(
            lab, folder / "servers", lambda name: self.seen.set(), self.used_by, self.used_by
        )
        self.arming = Arming(self.links.device_link, self.used_by, lambda name: None)
        of = (self.links.device_link,)
        self.acting = Acting(
            *of, self.arming, folder, lambda id: self.seen.set(), lambda name: None, lambda: least_s
        )
        self.jogging = Jogging(*of, self.acting, self.arming, lambda id: None)
        self.gantry = self.links.links["gantry"]

    def used_by(self, device):
        return None

    async def online(self):
        async with asyncio.timeout(500):
            while not self.gantry.online:
                self.seen.clear()
                await self.seen.wait()

    def move(self, x_mm, deadline=Deadline()):  # noqa: B008 - it never changes
        asked = CallAction(params={"x": f"{x_mm} mm"})
        return self.acting.call("gantry", "move_to", asked, "Ada", f"move to {x_mm}", deadline)

    def hold(self):
        asked = JogStart(axis="x", direction=1, feed_mm_min=1000)
        return self.jogging.start("gantry", asked, "Ada", Deadline())


@asynccontextmanager
async def bench(folder, **more):
    made = Bench(folder, **more)
    made.links.open()
    try:
        await made.online()
        yield made
    finally:
        await made.jogging.close()
        await made.acting.close()
        await made.links.close()


def refused(answers):
    return [answer.fault.code for answer in answers if isinstance(answer, Refusal)]


@pytest.mark.parametrize("other", ["an action", "a hold"])
def test_of_two_requests_at_the_same_instant_one_is_refused(tmp_path, other):
    async def story():
        async with bench(tmp_path) as made:
            second = made.move(20) if other == "an action" else made.hold()
            at_once = await asyncio.gather(made.move(10), second, return_exceptions=True)
            return at_once, await made.move(30)

    at_once, after = asyncio.run(story())

    assert refused(at_once) == ["BUSY"]
    assert after.state == "SUCCEEDED"


def test_an_action_that_is_over_keeps_nobody_from_the_next(tmp_path):
    async def story():
        async with bench(tmp_path) as made:
            first = asyncio.create_task(made.move(10))
            async with asyncio.timeout(500):
                while not any(made.acting.goal(id).ended_at for id in made.acting.newest()):
                    made.seen.clear()
                    await made.seen.wait()
            return made.gantry.busy, await made.move(30), await first

    busy, after, _ = asyncio.run(story())

    assert busy  # its lease is still being released
    assert after.state == "SUCCEEDED"


def test_what_acts_on_a_motion_is_refused_until_there_is_one(tmp_path):
    async def story():
        async with bench(tmp_path) as made:
            hold = made.acting.call("gantry", "hold", CallAction(), "Ada", "a hold", Deadline())
            return await asyncio.gather(made.move(10), hold, return_exceptions=True)

    moved, held = asyncio.run(story())

    assert moved.state == "SUCCEEDED" and refused([held]) == ["BUSY"]


def test_a_turn_ends_with_a_refusal(tmp_path):
    async def story():
        async with bench(tmp_path) as made:
            late = await asyncio.gather(made.move(10, Deadline(1.0)), return_exceptions=True)
            return late, await made.move(30)

    late, after = asyncio.run(story())

    assert refused(late) == ["LATE"] and after.state == "SUCCEEDED"


def test_a_clock_that_is_set_neither_loses_a_device_nor_its_position(tmp_path, monkeypatch):
    async def story():
        async with bench(tmp_path) as made:
            ahead = time.time() + 3600
            monkeypatch.setattr(time, "time", lambda: ahead)
            reach, here = made.gantry.reach, where_mm(made.gantry, "x")
            age_s = made.gantry.status_age_s
            monkeypatch.undo()
            return reach, here, age_s

    reach, here, age_s = asyncio.run(story())

    assert (reach, here) == ("online", 0) and 0 <= age_s < 3600


def test_an_action_that_takes_longer_than_the_settings_allow_is_cancelled(tmp_path):
    async def story():
        async with bench(tmp_path, clock=1e-6, least_s=0.05) as made:
            actions = made.gantry.contract.actions
            actions["move_to"] = actions["move_to"].model_copy(update={"duration": None})
            goal = await made.move(20)
            async with asyncio.timeout(500):
                while made.gantry.busy:
                    made.seen.clear()
                    await made.seen.wait()
            return made.acting.goal(goal.id)

    assert asyncio.run(story()).state == "CANCELED"
