"""One owner decides what begins on a device and what ends; only then is it in its safe state."""

import asyncio

import pytest

from labrun.drivers.driver import Driver

from . import lamp
from .lamp import LAST_ACT_S, SAFE_S, Lamp, Story


def test_a_stop_is_answered_by_a_safe_state_that_began_after_the_last_act():
    async def told(story):
        await story.take()
        goal = await story.goal()
        await story.until("begins", goal)
        answer = await story.device.stop()
        return answer, story.lamp.lit, story.lamp.acts

    answer, lit, acts = Story.tell(told)

    assert LAST_ACT_S < SAFE_S
    assert answer == (True, "lamp is in its safe state")
    assert not lit
    assert ("safe", "") in acts[acts.index(("over", "g1")) :]


def test_under_a_goal_that_is_slow_to_end_the_driver_is_called_once(monkeypatch):
    monkeypatch.setattr(lamp, "LAST_ACT_S", 2.5 * SAFE_S)

    async def told(story):
        await story.take()
        goal = await story.goal()
        await story.until("begins", goal)
        await story.device.stop()
        return story.lamp.acts

    acts = Story.tell(told)

    assert acts[1 : acts.index(("over", "g1"))] == [("safe", ""), ("safe over", "")]


@pytest.mark.parametrize("lapse", ["finish", "cancel", "safe"])
def test_no_goal_of_the_next_holder_is_made_safe_for_a_lapse_before_it(lapse):
    async def told(story):
        await story.take(ttl_s=5.0)
        first = await story.goal()
        await story.until("begins", first)
        await asyncio.sleep(5.1)
        await story.take("run-2")
        second = await story.goal()
        await asyncio.sleep(0.1)
        if lapse == "finish":
            story.lamp.ends[first].set()
        await story.until("begins", second)
        await asyncio.sleep(10.0)
        return story.lamp.acts, story.told

    acts, ended = Story.tell(told, on_lease_lapse=lapse, concurrent=True)
    before = acts[: acts.index(("begins", "g2"))]

    assert acts[len(before) :][:2] == [("begins", "g2"), ("safe", "")]  # the server's end
    assert before[before.index(("over", "g1")) :][-2:] == [("safe", ""), ("safe over", "")]
    assert ended == [("g1", "SUCCEEDED" if lapse == "finish" else "CANCELED"), ("g2", "CANCELED")]


def test_a_device_that_is_closed_leaves_nothing_running():
    async def told(story):
        await story.take()
        await story.until("begins", await story.goal())
        tasks = [story.device._owning, *(e.task for e in story.device.running.values())]
        await story.device.close()
        return [task.done() for task in tasks]

    assert Story.tell(told) == [True, True]


def test_a_device_is_not_at_rest_from_the_moment_of_a_stop():
    async def told(story):
        owner = story.device._owner
        await asyncio.sleep(0.1)
        before = owner.at_rest
        answer = owner.stop("Stopped", "by a person")
        during = owner.at_rest
        await answer
        await asyncio.sleep(0.1)
        return before, during, owner.at_rest

    assert Story.tell(told) == (True, False, True)


def test_without_a_safe_of_its_own_the_contracts_actions_are_done_in_order():
    class Plain(Driver):
        acts = ()

        async def dim(self, goal):
            self.acts += ("dim",)

        async def off(self, goal):
            self.acts += ("off",)

    async def told(story):
        return await story.device.stop(), story.lamp.acts

    actions = {"dim": {}, "off": {}}
    answer, acts = Story.tell(told, driver=Plain, safe_state=["dim", "off"], actions=actions)

    assert answer == (True, "lamp is in its safe state")
    assert acts == ("dim", "off")


@pytest.mark.parametrize(("safe_state", "touched"), [([], False), (["off"], True)])
def test_a_lapse_leaves_a_device_without_a_safe_state_as_it_is(safe_state, touched):
    """A resume would else zero a balance again, with liquid on its pan by then."""

    class Plain(Driver):
        async def off(self, goal):
            pass

    async def told(story):
        await story.take(ttl_s=5.0)
        epoch = story.device.lease.holder.epoch
        await asyncio.sleep(5.1)
        return epoch, story.device.lapsed

    epoch, lapsed = Story.tell(told, driver=Plain, safe_state=safe_state, actions={"off": {}})

    assert lapsed == (epoch if touched else 0)


def test_a_driver_that_raises_is_not_safe(caplog):
    class Broken(Lamp):
        async def safe(self):
            raise OSError("cable out")

    answer = Story.tell(lambda story: story.device.stop(), driver=Broken)

    assert answer == (False, "lamp may not be safe: OSError: cable out")
    assert "Traceback" in caplog.text


def test_who_asks_while_it_is_made_safe_and_nothing_acts_shares_the_answer():
    async def told(story):
        hasty = story.device.stop(SAFE_S / 2)
        return await asyncio.gather(hasty, story.device.stop()), list(story.lamp.acts)

    (hasty, patient), acts = Story.tell(told)

    assert acts == [("safe", ""), ("safe over", "")]
    assert hasty == (False, f"lamp did not confirm its safe state within {SAFE_S / 2:g} s")
    assert patient[0]


def test_a_shot_that_ends_well_while_its_device_is_made_safe_for_a_lapse_is_marked():
    class Deaf(Lamp):
        async def shine(self, goal):
            self.acts.append(("begins", goal.id))
            await asyncio.sleep(2.0)
            return {}

    async def told(story):
        await story.take(ttl_s=1.0)
        goal = await story.goal()
        await story.until("begins", goal)
        await asyncio.sleep(10.0)
        return story.ledger.report(goal)

    report = Story.tell(told, driver=Deaf, on_lease_lapse="safe")

    assert (report.state, report.error.name, report.error.happened) == ("SUCCEEDED", "Lost", "yes")
    assert "its lease was over" in report.error.message


@pytest.mark.parametrize(("grace", "grace_s"), [("10 min", 600.0), ("7 h", 25200.0)])
def test_what_a_lapsed_lease_still_does_after_its_time_is_aborted(grace, grace_s):
    async def told(story):
        await story.take(ttl_s=5.0)
        goal = await story.goal()
        await story.until("begins", goal)
        await asyncio.sleep(5.0 + grace_s - 1.0)
        acts = list(story.lamp.acts)
        await asyncio.sleep(10.0)
        return acts, story.lamp.acts, story.device.calm

    before, after, calm = Story.tell(told, lapse_grace=grace)

    assert before == [("begins", "g1")]
    assert after[1:3] == [("safe", ""), ("over", "g1")]  # made safe at once, and again below
    assert after[after.index(("over", "g1")) :][-2:] == [("safe", ""), ("safe over", "")]
    assert calm is True
