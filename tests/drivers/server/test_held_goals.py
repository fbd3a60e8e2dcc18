"""A goal that is sent again is still wanted, and starts nothing; some goals are taken meanwhile."""

import asyncio


def test_an_action_that_is_held_goes_on_as_long_as_its_goal_is_sent_again(bench):
    async def story():
        async with bench.connected() as client:
            goal = bench.goal(client, "held", seconds=0.5)
            ending = asyncio.create_task(client.follow(goal))
            kept = []
            for _ in range(10):
                await asyncio.sleep(0.1)
                kept.append(await client.keep(goal))
            outcome = await ending
            return kept, outcome, await client.keep(goal)

    kept, outcome, after = asyncio.run(story())

    assert all(kept)
    assert outcome.state == "SUCCEEDED"
    assert after is False
    assert [deed for deed in bench.deeds() if "held" in deed] == ["arm held run-1/main/1/1"]


def test_a_goal_of_a_lease_that_is_over_is_not_kept(bench):
    async def story():
        async with bench.connected() as client:
            goal = bench.goal(client, "held", seconds=0.4)
            ending = asyncio.create_task(client.follow(goal))
            await bench.until("held run-1/main/1/1")
            stale = goal.model_copy(update={"epoch": goal.epoch - 1})
            async with asyncio.timeout(500):
                while not ending.done():
                    await client.keep(stale)
                    await asyncio.sleep(0.05)
            return ending.result()

    assert asyncio.run(story()).state == "SUCCEEDED"


def test_an_action_that_may_be_asked_for_meanwhile_is_taken_while_another_is_under_way(bench):
    async def story():
        async with bench.connected() as client:
            held = bench.goal(client, "hold", seconds=60)
            first = asyncio.create_task(client.follow(held))
            await bench.until("hold run-1/main/1/1")
            nudged = await client.follow(bench.goal(client, "nudge"))
            busy = await client.follow(bench.goal(client, "go", x=1))
            await client.cancel(held.id)
            return nudged, busy, await first

    nudged, busy, first = asyncio.run(story())

    assert (nudged.state, first.state) == ("SUCCEEDED", "CANCELED")
    assert busy.state == "ABORTED" and "busy" in busy.error.message
