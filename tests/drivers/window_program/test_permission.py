"""A thread that outlives its goal is not allowed to click by the next one."""

import asyncio
import threading

from labrun.drivers.window_program.permission import Permission


def test_a_thread_of_a_halted_or_cancelled_goal_stays_halted_when_the_next_goal_begins():
    permission, cancelled = Permission(), []
    going_on, seen = threading.Event(), []

    def late():
        going_on.wait(10)
        seen.append(permission.halted)

    async def old(halted):
        permission.allow(lambda: "old" in cancelled)
        before = permission.halted
        clicking = asyncio.create_task(asyncio.to_thread(late))
        await asyncio.sleep(0)
        if halted:
            permission.halt()
        else:
            cancelled.append("old")
        return before, clicking

    async def new():
        permission.allow(lambda: "new" in cancelled)
        return permission.halted

    async def story(halted):
        going_on.clear()
        before, clicking = await asyncio.create_task(old(halted))
        after = await asyncio.create_task(new())
        going_on.set()
        await clicking
        return before, after

    assert asyncio.run(story(halted=True)) == (False, False)
    cancelled.clear()
    assert asyncio.run(story(halted=False)) == (False, False)
    assert seen == [True, True]


def test_what_was_not_allowed_since_a_halt_is_halted():
    permission = Permission()
    assert not permission.halted

    permission.halt()

    assert permission.halted
