"""While a disk takes its time to sync, a stop is answered, and no promise waits any less."""

import asyncio
import threading
from contextlib import asynccontextmanager
from functools import partial

import pytest


class SlowSync:
    """The next call of one of the ledger's methods reaches the disk only when the test says so."""

    def __init__(self, ledger, method):
        self._begun, self._go = threading.Event(), threading.Event()
        write = getattr(ledger, method)

        def slowly(*args):
            setattr(ledger, method, write)
            self._begun.set()
            assert self._go.wait(20), "the event loop waits for the sync"
            return write(*args)

        setattr(ledger, method, slowly)

    async def begun(self):
        assert await asyncio.to_thread(self._begun.wait, 20)

    def ends(self):
        self._go.set()


@asynccontextmanager
async def slow(bench, method, safe_s=0, **goal):
    """A server whose ledger will be slow, its holder with a goal to send, and a passer-by."""
    config = {"safe_s": safe_s}
    async with (
        bench.serving(config=config) as (server, url),
        bench.raw(url) as raw,
        bench.raw(url) as other,
    ):
        goal = await raw.leased(**goal)
        yield raw, other, goal, SlowSync(server.ledger, method)


def test_a_stop_is_answered_while_a_goal_is_being_admitted_and_the_goal_never_starts(bench):
    async def story():
        async with slow(bench, "admit") as (raw, other, goal, sync):
            sent = asyncio.create_task(raw.call("goal", **goal))
            await sync.begun()
            stopped = await other.call("stop", device="arm")
            deeds = bench.deeds()
            waits = not sent.done()
            sync.ends()
            await sent
            return stopped, deeds, waits, await raw.update("g1", "CANCELED")

    stopped, deeds, waits, update = asyncio.run(story())

    assert (stopped["safe"], deeds, waits) == (True, ["arm safe"], True)
    assert (update["error"]["name"], update["error"]["happened"]) == ("Stopped", "no")
    assert "arm go g1" not in bench.deeds()


def test_a_goal_that_came_before_its_own_holders_stop_never_starts_after_it(bench):
    async def story():
        async with slow(bench, "report") as (raw, other, goal, sync):
            asking = asyncio.create_task(other.call("query", ids=["g0"]))
            await sync.begun()
            sent = asyncio.create_task(raw.call("goal", **goal))  # waits until that is answered
            stopped = await asyncio.create_task(raw.call("stop", device="arm"))
            sync.ends()
            await asking
            return stopped, await sent, await raw.call("goal", **{**goal, "id": "g2"})

    stopped, refused, later = asyncio.run(story())

    assert stopped["safe"]
    assert refused["code"] == "STOPPED"
    assert "arm was stopped by the client that uses it" in refused["message"]
    assert refused["message"].endswith(", before the goal began")
    assert later["ok"]  # its holder has stopped it, and goes on
    assert "arm go g1" not in bench.deeds()


@pytest.mark.parametrize("method", ["end", "lease", "report"])
def test_a_stop_is_answered_while_anything_else_is_written_or_read(bench, method):
    async def story():
        async with slow(bench, method) as (raw, other, goal, sync):
            asked = {
                "end": partial(raw.call, "goal", **goal),
                "lease": raw.leased,
                "report": partial(raw.call, "query", ids=["g1"]),
            }
            asking = asyncio.create_task(asked[method]())
            await sync.begun()
            stopped = await other.call("stop", device="arm")
            told = [data for event, data in raw.events if data.get("state") == "SUCCEEDED"]
            sync.ends()
            answer = await asking
            late = {**goal, "id": "g2", "epoch": answer.get("epoch", goal["epoch"])}
            return stopped, told, await raw.call("goal", **late)

    stopped, told, late = asyncio.run(story())

    assert stopped["safe"]
    assert told == []  # an outcome is in the ledger before it is told
    assert "stopped by another client" in late["message"]  # though its lease is newer


async def admitted_while_stopping(bench, raw, goal):
    """A stop that is being carried out, and the answer to a goal that waits for its end."""
    stopping = asyncio.create_task(raw.call("stop"))
    await bench.until("safe")
    return stopping, await raw.call("goal", **goal)


def test_a_stop_is_answered_while_a_goal_that_waited_is_written_to_begin(bench):
    async def story():
        async with slow(bench, "begin", safe_s=0.5) as (raw, _, goal, sync):
            stopping, accepted = await admitted_while_stopping(bench, raw, goal)
            await sync.begun()
            stopped = await raw.call("stop")
            sync.ends()
            await stopping
            return accepted, stopped, await raw.update("g1", "CANCELED")

    accepted, stopped, update = asyncio.run(story())

    assert (accepted["state"], stopped["safe"]) == ("ACCEPTED", True)
    assert (update["error"]["name"], update["error"]["happened"]) == ("Stopped", "no")
    assert "arm go g1" not in bench.deeds()


def test_a_goal_that_waited_tells_the_mark_of_its_beginning(bench):
    async def story():
        async with slow(bench, "bury", safe_s=0.1) as (raw, _, goal, _):
            stopping, accepted = await admitted_while_stopping(bench, raw, goal)
            await stopping
            return accepted, await raw.update("g1", "EXECUTING")

    accepted, began = asyncio.run(story())

    number = [int(told["mark"].split(":")[1]) for told in (accepted, began)]
    assert accepted["state"] == "ACCEPTED" and number[0] < number[1]


def test_while_a_goal_is_being_admitted_its_copy_its_cancel_and_other_goals_keep_their_order(bench):
    async def story():
        async with slow(bench, "admit", action="hold", params={"seconds": 20}) as (
            raw, _, goal, sync,
        ):  # fmt: skip
            requests = [("goal", goal), ("goal", goal), ("goal", {**goal, "id": "g2"})]
            sent = [asyncio.create_task(raw.call(e, **data)) for e, data in requests]
            await sync.begun()
            sent.append(asyncio.create_task(raw.call("cancel", id="g1")))
            sync.ends()
            answers = await asyncio.gather(*sent)
            return answers, await raw.update("g1", "CANCELED")

    (first, copy, second, cancelled), _ = asyncio.run(story())

    assert (first["state"], "dup" in first) == ("EXECUTING", False)
    assert copy["dup"]
    assert second["code"] == "BUSY"
    assert cancelled["state"] == "CANCELING"
    assert bench.deeds().count("arm hold g1") <= 1


def test_a_lease_is_renewed_and_a_running_goal_kept_and_cancelled_while_a_sync_takes_long(bench):
    async def story():
        hold = {"action": "hold", "params": {"seconds": 20}}
        async with slow(bench, "bury", **hold) as (raw, other, goal, sync):
            await raw.call("goal", **goal)
            burying = asyncio.create_task(other.call("cancel", id="g9"))
            await sync.begun()
            renewal = {"device": "arm", "owner": "raw", "ttl_s": 30.0, "epoch": goal["epoch"]}
            renewed = await raw.call("lease", **renewal)
            kept = await raw.call("goal", **goal)
            cancelled = await raw.call("cancel", id="g1")
            sync.ends()
            await burying
            return renewed, kept, cancelled

    renewed, kept, cancelled = asyncio.run(story())

    assert renewed["ok"] and kept["dup"]
    assert cancelled["state"] == "CANCELING"
