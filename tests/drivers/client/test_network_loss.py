"""The promises about the wire, kept over a wire that loses, doubles, delays, freezes and breaks."""

import asyncio
import contextlib
import logging
from collections import Counter
from contextlib import asynccontextmanager
from dataclasses import replace

import pytest

from labrun.drivers.client.client import LeaseHeld
from labrun.drivers.client.launch import start_server
from labrun.drivers.client.link import Link
from labrun.drivers.simulated.twins.bad_network import HOLD_S, FaultyWire, WireFaults

FAULTS = {
    "drop_request": WireFaults(drop_request=0.25),
    "drop_reply": WireFaults(drop_reply=0.25),
    "duplicate": WireFaults(duplicate=0.5),
    "reorder": WireFaults(reorder=0.5),
    "hang": WireFaults(hang=0.03, hang_s=0.3),
    "cut": WireFaults(cut=0.08),
    "all": WireFaults(
        drop_request=0.05, drop_reply=0.05, duplicate=0.2, reorder=0.2,
        hang=0.01, hang_s=0.3, cut=0.03,
    ),
}  # fmt: skip


@pytest.fixture
def impatient(monkeypatch):
    """A client that asks sooner what became of its goals, so that many losses fit into a test."""
    monkeypatch.setattr("labrun.drivers.client.goal_tracking.ANSWER_S", 0.3)
    monkeypatch.setattr("labrun.drivers.client.goal_tracking.BEAT_MISSED_S", 0.5)
    monkeypatch.setattr("labrun.drivers.client.goal_watch.LOOK_S", 0.1)
    monkeypatch.setattr(Link.call, "__defaults__", (0.5, None))


def test_a_loss_is_told_in_words_of_ours_alone(caplog):
    for words in ("packet queue is empty, aborting", "message handler error"):
        logging.getLogger("engineio.client").error(words)

    assert caplog.messages == ["message handler error"]


async def kill(server):
    with contextlib.suppress(ProcessLookupError):
        server.process.kill()
    await server.process.wait()


@asynccontextmanager
async def badly_wired(bench, faults=None, **settings):
    """A device server in a process of its own, and a wire to it that may be told to go bad."""
    server = await start_server(bench.settings(**settings), bench.folder)
    wire = FaultyWire(server.url, faults or WireFaults())
    try:
        await wire.open()
        yield server, wire
    finally:
        await wire.close()
        await kill(server)  # an orderly end is no part of these stories


async def until(true, timeout_s=500):
    async with asyncio.timeout(timeout_s):
        while not true():  # noqa: ASYNC110 - whatever it waits for may be in another process
            await asyncio.sleep(0.01)


async def ended(client, *ids):
    """Wait until the server itself says that goals have ended, and how."""
    async with asyncio.timeout(500):
        while True:
            reports = (await client.query(list(ids))).goals.values()
            if all(report is not None and report.ended for report in reports):
                return [report.state for report in reports]
            await asyncio.sleep(0.02)


def done(bench, action):
    """Goal id -> how often the device really did it, by its own record."""
    start = f"arm {action} "
    return Counter(deed.removeprefix(start) for deed in bench.deeds() if deed.startswith(start))


def assert_true(verdicts, deeds):
    """Nothing was done twice, and no verdict says what the device's record does not."""
    happened = {i: v.error.happened if v.error else "yes" for i, v in verdicts.items()}

    assert max(deeds.values(), default=0) <= 1
    assert set(deeds) <= set(verdicts)
    assert {i for i, word in happened.items() if word == "yes"} <= set(deeds)
    assert not {i for i, word in happened.items() if word == "no"} & set(deeds)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), [*((kind, 1) for kind in FAULTS), ("all", 3)])
def test_no_goal_is_done_twice_and_every_verdict_is_true(bench, impatient, kind, seed):
    verdicts = {}

    async def follow_goals(client):
        for seconds in [0, 0.02, 0.1]:
            goal = bench.goal(client, "press", seconds=seconds)
            verdicts[goal.id] = await client.follow(goal)

    async def story():
        async with (
            badly_wired(bench, contract={"concurrent": True}) as (server, wire),
            bench.client(wire.url) as client,
            bench.client(server.url, lease=False) as witness,
        ):
            wire.faults = replace(FAULTS[kind], seed=seed)
            async with asyncio.timeout(500):
                await asyncio.gather(*(follow_goals(client) for _ in range(10)))
            await asyncio.sleep(HOLD_S + 0.1)  # a late copy must find nothing to do
            return wire.done, await ended(witness, *verdicts)

    committed, recorded = asyncio.run(story())
    deeds = done(bench, "press")

    assert_true(verdicts, deeds)
    assert [verdict.state for verdict in verdicts.values()] == recorded
    assert set(recorded) == {"SUCCEEDED"}
    assert set(deeds) == set(verdicts)
    assert committed.total() > 0 if kind == "all" else set(committed) == {kind}


def test_goals_that_are_cancelled_over_a_bad_wire_end_and_stay_ended(bench, impatient):
    async def story():
        async with (
            badly_wired(bench, contract={"concurrent": True}) as (server, wire),
            bench.client(wire.url) as client,
            bench.client(server.url, lease=False) as witness,
        ):
            wire.faults = FAULTS["all"]
            goals = [bench.goal(client, "hold", seconds=50) for _ in range(12)]
            following = [asyncio.create_task(client.follow(goal)) for goal in goals]
            await until(
                lambda: len(done(bench, "hold")) > 3
            )  # the others may still be on their way
            await asyncio.gather(*(client.cancel(goal.id) for goal in goals))
            outcomes = await asyncio.gather(*following)
            await asyncio.sleep(HOLD_S + 0.1)
            return outcomes, await ended(witness, *(goal.id for goal in goals))

    outcomes, recorded = asyncio.run(story())

    assert [outcome.state for outcome in outcomes] == recorded == ["CANCELED"] * 12
    assert max(done(bench, "hold").values()) == 1


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_goal_that_was_refused_is_not_done_by_a_late_copy_of_it(bench, impatient, seed):
    verdicts = {}

    async def follow_goals(client):
        for _ in range(7):
            goal = bench.goal(client, "press", seconds=0.05)
            verdicts[goal.id] = await client.follow(goal)

    async def story():
        async with badly_wired(bench) as (_, wire), bench.client(wire.url) as client:
            wire.faults = WireFaults(seed=seed, duplicate=0.7, reorder=0.3)
            await asyncio.gather(*(follow_goals(client) for _ in range(4)))
            await asyncio.sleep(HOLD_S + 0.1)

    asyncio.run(story())
    refused = [v for v in verdicts.values() if v.error is not None and v.error.name == "Busy"]

    assert_true(verdicts, done(bench, "press"))
    assert refused


@pytest.mark.parametrize("broken", ["cut", "frozen"])
def test_goals_go_on_without_the_wire_and_are_told_when_it_is_back(bench, broken):
    async def story():
        async with (
            badly_wired(bench, contract={"concurrent": True}) as (server, wire),
            bench.client(wire.url) as client,
            bench.client(server.url, lease=False) as witness,
        ):
            goals = [bench.goal(client, "press", seconds=0.3) for _ in range(5)]
            following = [asyncio.create_task(client.follow(goal)) for goal in goals]
            await until(lambda: len(done(bench, "press")) == 5)
            wire.freeze(1.0)
            if broken == "cut":
                wire.cut()
            await ended(witness, *(goal.id for goal in goals))
            told_early = [task.done() for task in following]
            return told_early, await asyncio.gather(*following)

    told_early, outcomes = asyncio.run(story())

    assert not any(told_early)
    assert [outcome.state for outcome in outcomes] == ["SUCCEEDED"] * 5
    assert set(done(bench, "press").values()) == {1}


def test_goals_sent_into_a_wire_that_is_given_up_are_done_once(bench):
    async def story():
        links = []
        async with (
            badly_wired(bench, contract={"concurrent": True}) as (_, wire),
            bench.client(wire.url, on_link=links.append) as client,
        ):
            wire.freeze(4.4)
            goals = [bench.goal(client, "press") for _ in range(10)]
            outcomes = await asyncio.gather(*(client.follow(goal) for goal in goals))
            await until(lambda: links[-1])
            await asyncio.sleep(0.2)
            return {goal.id: outcome for goal, outcome in zip(goals, outcomes, strict=True)}, links

    verdicts, links = asyncio.run(story())

    assert False in links
    assert_true(verdicts, done(bench, "press"))
    assert {verdict.state for verdict in verdicts.values()} == {"SUCCEEDED"}


def test_a_server_that_was_started_anew_elsewhere_is_followed_there(bench, impatient):
    async def story():
        async with (
            badly_wired(bench, contract={"concurrent": True}) as (first, wire),
            bench.client(wire.url) as client,
        ):
            over = await client.follow(bench.goal(client, "press"))
            cut_off = bench.goal(client, "press", seconds=30)
            following = asyncio.create_task(client.follow(cut_off))
            await bench.until(f"press {cut_off.id}")
            epoch = client.epoch("arm")
            wire.freeze(1000)
            never = bench.goal(client, "press")
            never_arrived = asyncio.create_task(client.follow(never))
            await asyncio.sleep(0.1)
            wire.cut()
            await kill(first)
            second = await start_server(bench.settings(contract={"concurrent": True}), bench.folder)
            try:
                wire.target = second.url
                wire.stillness.end()
                await until(lambda: client.epoch("arm") > epoch)
                after = await client.follow(bench.goal(client, "press"))
                return over, await following, await never_arrived, after, never
            finally:
                await kill(second)

    over, cut_off, never_arrived, after, never = asyncio.run(story())

    assert (over.state, after.state) == ("SUCCEEDED", "SUCCEEDED")
    assert (cut_off.error.name, cut_off.error.happened) == ("Lost", "unknown")
    assert (never_arrived.error.name, never_arrived.error.happened) == ("Lost", "no")
    assert never.id not in done(bench, "press")


@pytest.mark.parametrize(
    ("then", "action", "fate"),
    [
        ("finish", "hold", "SUCCEEDED"),
        ("cancel", "hold", "CANCELED"),
        ("cancel", "press", "SUCCEEDED"),  # its contract lets nobody cancel it
        ("safe", "hold", "CANCELED"),
    ],
)
def test_a_lease_that_lapses_in_a_freeze_ends_safe_and_is_taken_again(bench, then, action, fate):
    async def story():
        async with (
            badly_wired(bench, contract={"on_lease_lapse": then}) as (server, wire),
            bench.client(wire.url, lease=False) as client,
            bench.client(server.url, lease=False) as witness,
        ):
            before = await client.take_lease("arm", "run-1", ttl_s=3)
            goal = bench.goal(client, action, seconds=4.5)
            following = asyncio.create_task(client.follow(goal))
            await bench.until(f"{action} {goal.id}")
            wire.freeze(600)
            await bench.until("safe")
            seen = await ended(witness, goal.id)
            wire.stillness.end()
            outcome = await following
            await until(lambda: client.epoch("arm") > before)
            return seen, outcome, await client.follow(bench.goal(client, "go", x=1))

    seen, outcome, after = asyncio.run(story())

    assert seen == [outcome.state] == [fate]
    assert after.state == "SUCCEEDED"
    assert sum(done(bench, action).values()) == 1


def test_a_goal_of_a_lease_that_lapsed_on_its_way_is_refused_and_not_done(bench):
    async def story():
        async with (
            badly_wired(bench) as (_, wire),
            bench.client(wire.url, lease=False) as client,
        ):
            before = await client.take_lease("arm", "run-1", ttl_s=0.4)
            wire.freeze(0.9)
            goal = bench.goal(client, "press")
            outcome = await client.follow(goal)
            await until(lambda: client.epoch("arm") > before)
            return outcome, await client.follow(bench.goal(client, "go", x=1))

    outcome, after = asyncio.run(story())

    assert (outcome.error.name, outcome.error.happened) == ("Lost", "no")
    assert "epoch" in outcome.error.message
    assert not done(bench, "press")
    assert after.state == "SUCCEEDED"


def test_a_device_changes_hands_after_the_lapse_and_not_before(bench):
    async def take(client):
        async with asyncio.timeout(500):
            while True:
                try:
                    return await client.take_lease("arm", "run-2")
                except LeaseHeld:
                    await asyncio.sleep(0.05)

    async def story():
        async with (
            badly_wired(bench) as (server, wire),
            bench.client(wire.url, lease=False) as first,
            bench.client(server.url, lease=False) as second,
        ):
            await first.take_lease("arm", "run-1", ttl_s=1.5)
            wire.freeze(0.5)
            wire.cut()
            with pytest.raises(LeaseHeld, match="arm is held by run-1"):
                await second.take_lease("arm", "run-2")
            through = await first.follow(bench.goal(first, "go", x=1))
            wire.freeze(1000)
            sent_blind = bench.goal(first, "press")
            following = asyncio.create_task(first.follow(sent_blind))
            await take(second)
            theirs = await second.follow(bench.goal(second, "go", x=2))
            wire.stillness.end()
            blind = await following
            late = await first.follow(bench.goal(first, "press"))
            still_theirs = await second.follow(bench.goal(second, "go", x=3))
            return through, theirs, blind, late, still_theirs

    through, theirs, blind, late, still_theirs = asyncio.run(story())

    assert [o.state for o in (through, theirs, still_theirs)] == ["SUCCEEDED"] * 3
    for refused in (blind, late):
        assert (refused.error.name, refused.error.happened) == ("Rejected", "no")
        assert "run-2 holds it now" in refused.error.message
    assert not done(bench, "press")


def test_a_stop_works_over_another_connection_while_the_wire_is_frozen(bench):
    async def story():
        async with (
            badly_wired(bench) as (server, wire),
            bench.client(wire.url) as client,
            bench.client(server.url, lease=False) as bystander,
        ):
            goal = bench.goal(client, "hold", seconds=30)
            following = asyncio.create_task(client.follow(goal))
            await bench.until(f"hold {goal.id}")
            wire.freeze(1000)
            sent_blind = asyncio.create_task(client.follow(bench.goal(client, "press")))
            await asyncio.sleep(0.1)
            stop = await bystander.stop("arm")
            deeds = bench.deeds()
            told_early = following.done()
            wire.stillness.end()
            late = await client.follow(bench.goal(client, "press"))
            return stop, deeds, told_early, await following, await sent_blind, late

    stop, deeds, told_early, outcome, blind, late = asyncio.run(story())

    assert stop == {"arm": (True, "arm is in its safe state")}
    assert "arm safe" in deeds
    assert not told_early
    assert outcome.state == "CANCELED"
    for refused in (blind, late):
        assert (refused.error.name, refused.error.happened) == ("Stopped", "no")
    assert "stopped by another client" in late.error.message
    assert not done(bench, "press")


@pytest.mark.parametrize("lapsed", [False, True])
def test_an_engine_that_takes_its_lease_again_by_itself_does_not_undo_a_stop(bench, lapsed):
    async def story():
        async with (
            badly_wired(bench) as (server, wire),
            bench.client(wire.url, lease=False) as client,
            bench.client(server.url, lease=False) as bystander,
        ):
            before = await client.take_lease("arm", "run-1", ttl_s=0.4)
            wire.freeze(1.2)
            if lapsed:
                await bench.until("safe")
            stop = await bystander.stop("arm")
            await until(lambda: client.epoch("arm") > before)
            refused = await client.follow(bench.goal(client, "press"))
            await client.take_lease("arm", "run-1")
            return stop, refused, await client.follow(bench.goal(client, "go", x=1))

    stop, refused, after = asyncio.run(story())

    assert stop["arm"][0]
    assert (refused.error.name, refused.error.happened) == ("Stopped", "no")
    assert "stopped by another client" in refused.error.message
    assert not done(bench, "press")
    assert after.state == "SUCCEEDED"


@pytest.mark.parametrize("lost", ["drop_request", "drop_reply", "cut"])
def test_a_lease_is_taken_although_its_message_or_its_answer_is_lost(bench, impatient, lost):
    async def story():
        async with (
            badly_wired(bench) as (_, wire),
            bench.client(wire.url, lease=False) as client,
        ):
            wire.faults = WireFaults(**{lost: 1.0})
            taking = asyncio.create_task(client.take_lease("arm", "run-1"))
            await until(lambda: wire.done[lost])
            wire.faults = WireFaults()
            await taking
            return await client.follow(bench.goal(client, "go", x=1))

    assert asyncio.run(story()).state == "SUCCEEDED"


@pytest.mark.parametrize("lost", ["drop_request", "drop_reply", "cut"])
def test_a_lease_is_given_back_although_its_message_or_its_answer_is_lost(bench, impatient, lost):
    async def story():
        async with (
            badly_wired(bench) as (server, wire),
            bench.client(wire.url) as client,
            bench.client(server.url, lease=False) as other,
        ):
            wire.faults = WireFaults(**{lost: 1.0})
            leaving = asyncio.create_task(client.release("arm"))
            await until(lambda: wire.done[lost])
            wire.faults = WireFaults()
            await leaving
            return await other.take_lease("arm", "run-2")

    assert asyncio.run(story()) == 2


def test_a_lease_whose_messages_come_twice_is_given_once(bench):
    async def story():
        async with (
            badly_wired(bench, faults=WireFaults(duplicate=1.0)) as (_, wire),
            bench.client(wire.url) as client,
        ):
            await asyncio.sleep(HOLD_S + 0.1)
            outcome = await client.follow(bench.goal(client, "go", x=1))
            return client.epoch("arm"), outcome

    epoch, outcome = asyncio.run(story())

    assert epoch == 1
    assert outcome.state == "SUCCEEDED"


def test_a_late_copy_of_a_lease_undoes_neither_a_release_nor_a_stop(bench):
    async def story():
        async with (
            badly_wired(bench, faults=WireFaults(duplicate=1.0)) as (server, wire),
            bench.client(wire.url, lease=False) as client,
            bench.client(server.url, lease=False) as other,
        ):
            await client.take_lease("arm", "run-1")
            await other.stop("arm")
            await asyncio.sleep(HOLD_S + 0.1)
            stopped = await client.follow(bench.goal(client, "press"))
            await client.take_lease("arm", "run-1")
            await client.release("arm")
            await asyncio.sleep(HOLD_S + 0.1)
            await other.take_lease("arm", "run-2")
            return stopped, await other.follow(bench.goal(other, "go", x=1))

    stopped, theirs = asyncio.run(story())

    assert (stopped.error.name, stopped.error.happened) == ("Stopped", "no")
    assert "stopped by another client" in stopped.error.message
    assert theirs.state == "SUCCEEDED"
