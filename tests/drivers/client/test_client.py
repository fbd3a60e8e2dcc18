"""Follow goals through everything that may happen to a connection and to a server."""

import asyncio
import contextlib
import gc
import math
import os
import signal
import socket
import warnings
from contextlib import asynccontextmanager
from hashlib import sha256

import pytest
from aiohttp import web

from labrun.drivers.client.client import DeviceClient, LeaseHeld, ServerUnreachable
from labrun.drivers.client.launch import start_server
from labrun.drivers.client.link import Denied, Link, LinkDown
from labrun.schemas.messages import FileContent


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@asynccontextmanager
async def own_process(bench, **settings):
    """A server in a process of its own, that a test may kill."""
    server = await start_server(bench.settings(**settings), bench.folder)
    try:
        yield server
    finally:
        await server.stop()


async def kill(server):
    os.kill(server.pid, signal.SIGKILL)
    await server.process.wait()


async def until(true, timeout_s=500):
    async with asyncio.timeout(timeout_s):
        while not true():  # noqa: ASYNC110 - whatever it waits for may be in another process
            await asyncio.sleep(0.01)


def test_a_goal_that_is_asked_about_brings_a_mark_too_since_its_acknowledgement_may_be_lost(bench):
    async def story():
        heard = []
        async with bench.serving() as (server, url), bench.client(url) as client:
            goal = bench.goal(client, "hold", seconds=60)
            sent = asyncio.create_task(client.follow(goal))
            await bench.until(f"hold {goal.id}")
            async with bench.client(url, lease=False) as other:
                asked = asyncio.create_task(other.follow(goal, heard.append, send=False))
                await until(lambda: any(report.mark for report in heard))
                await client.cancel(goal.id)
                await asyncio.gather(sent, asked)
            return server.ledger.report(goal.id), server.ledger.has(
                next(report.mark for report in heard if report.mark)
            )

    ended, known = asyncio.run(story())

    assert ended.state == "CANCELED"
    assert known


def test_a_goal_is_followed_to_its_end(bench):
    async def story():
        async with bench.connected() as client:
            reports = []
            outcome = await client.follow(bench.goal(client, "hold", seconds=0.1), reports.append)
            return outcome, reports, client

    outcome, reports, client = asyncio.run(story())

    assert (outcome.state, outcome.result, outcome.error) == ("SUCCEEDED", {"held": 0.1}, None)
    assert outcome.boot == client.boot
    assert any(report.progress == 0.5 and report.message == "half way" for report in reports)


def test_many_goals_are_followed_at_once(bench):
    async def story():
        async with bench.connected(contract={"concurrent": True}) as client:
            goals = [bench.goal(client, "hold", seconds=0.01 * n) for n in range(40)]
            return await asyncio.gather(*(client.follow(goal) for goal in goals))

    outcomes = asyncio.run(story())

    assert [outcome.result["held"] for outcome in outcomes] == [0.01 * n for n in range(40)]


def test_a_file_travels_both_ways(bench):
    data = os.urandom(400_000)
    file = FileContent(path="in.bin", sha256=sha256(data).hexdigest(), data=data)

    async def story():
        async with bench.connected() as client:
            asked = {"source": "in.bin", "file": "out/back.bin"}
            return await client.follow(bench.goal(client, "copy", files={"source": file}, **asked))

    outcome = asyncio.run(story())

    assert outcome.files["file"].path == "out/back.bin"
    assert outcome.files["file"].data == data[::-1]


def test_files_beyond_what_a_message_holds_are_refused_before_they_are_sent(bench, monkeypatch):
    monkeypatch.setattr("labrun.drivers.client.client.MAX_FILES_BYTES", 10)
    file = FileContent(path="in.bin", sha256="", data=b"eleven bytes")

    async def story():
        async with bench.connected() as client:
            return await client.follow(bench.goal(client, "copy", files={"source": file}))

    error = asyncio.run(story()).error

    assert (error.name, error.happened) == ("Rejected", "no")


def test_a_busy_device_and_a_wrong_parameter_surely_did_nothing(bench):
    async def story():
        async with bench.connected() as client:
            first = asyncio.create_task(client.follow(bench.goal(client, "hold", seconds=20)))
            await bench.until("hold run-1/main/1/1")
            busy = await client.follow(bench.goal(client, "go", x=1))
            wrong = await client.follow(bench.goal(client, "go", x=99))
            await client.cancel("run-1/main/1/1")
            return busy, wrong, await first

    busy, wrong, first = asyncio.run(story())

    assert (busy.state, busy.error.name, busy.error.happened) == ("ABORTED", "Busy", "no")
    assert (wrong.error.name, wrong.error.happened) == ("Rejected", "no")
    assert "99 mm is above the maximum" in wrong.error.message
    assert first.state == "CANCELED"


def test_a_cancel_that_comes_first_keeps_the_goal_from_starting(bench):
    async def story():
        async with bench.connected() as client:
            goal = bench.goal(client, "go", x=1)
            await client.cancel(goal.id)
            return await client.follow(goal)

    outcome = asyncio.run(story())

    assert outcome.state == "CANCELED"
    assert not [deed for deed in bench.deeds() if "go" in deed]


def test_giving_up_the_wait_leaves_the_goal_alone_and_it_can_be_followed_again(bench):
    async def story():
        async with bench.connected() as client:
            goal = bench.goal(client, "hold", seconds=0.5)
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.1):
                    await client.follow(goal)
            return await client.follow(goal)

    outcome = asyncio.run(story())

    assert outcome.state == "SUCCEEDED"
    assert len([deed for deed in bench.deeds() if "hold" in deed]) == 1


def test_a_fault_of_the_listener_comes_out_where_the_goal_is_awaited(bench):
    def broken(report):
        raise KeyError("no such row")

    async def story():
        async with bench.connected() as client:
            with pytest.raises(KeyError, match="no such row"):
                await client.follow(bench.goal(client, "hold", seconds=0.2), broken)
            return await client.follow(bench.goal(client, "answer", value=1))

    with_busy = asyncio.run(story())

    assert with_busy.error is None or with_busy.error.name == "Busy"


def test_a_lease_is_refused_with_the_holder_and_is_free_after_its_release(bench):
    async def story():
        async with (
            bench.serving() as (_, url),
            bench.client(url) as mine,
            bench.client(url, lease=False) as theirs,
        ):
            with pytest.raises(LeaseHeld, match="arm is held by run-1"):
                await theirs.take_lease("arm", "page")
            await mine.release("arm")
            await theirs.take_lease("arm", "page")
            return await mine.follow(bench.goal(mine, "go", x=1))

    error = asyncio.run(story()).error

    assert (error.name, error.happened) == ("Rejected", "no")
    assert "page holds it now" in error.message


def test_a_lease_is_renewed_until_it_is_released(bench, monkeypatch):
    async def story():
        async with bench.serving() as (_, url), bench.client(url, lease=False) as client:
            call, asked = client._link.call, asyncio.Queue()

            async def kept(event, request):
                if event == "lease":  # a busy machine may renew late; here that costs no lease
                    asked.put_nowait(request)
                    request = {**request, "ttl_s": 600}
                return await call(event, request)

            monkeypatch.setattr(client._link, "call", kept)
            epoch = await client.take_lease("arm", "run-1", ttl_s=0.3)
            async with asyncio.timeout(500):
                taken, *renewals = [await asked.get() for _ in range(4)]
            outcome = await client.follow(bench.goal(client, "go", x=1))
            await client.release("arm")
            asked = asyncio.Queue()
            await asyncio.sleep(0.3)
            return epoch, taken, renewals, outcome, asked.qsize()

    epoch, taken, renewals, outcome, after = asyncio.run(story())

    assert "epoch" not in taken
    assert [request["epoch"] for request in renewals] == [epoch] * 3
    assert outcome.state == "SUCCEEDED"
    assert after == 0


def test_a_lease_whose_renewal_fails_unexpectedly_is_renewed_all_the_same(
    bench, monkeypatch, caplog
):
    async def story():
        async with bench.serving() as (_, url), bench.client(url, lease=False) as client:
            call, renewals = client._link.call, asyncio.Queue()

            async def first_without_an_epoch(event, *request):
                if event != "lease":
                    return await call(event, *request)
                renewals.put_nowait(event)
                return {"ok": True} if not caplog.records else await call(event, *request)

            await client.take_lease("arm", "run-1", ttl_s=0.1)
            monkeypatch.setattr(client._link, "call", first_without_an_epoch)
            async with asyncio.timeout(500):
                for _ in range(3):
                    await renewals.get()

    asyncio.run(story())

    (record,) = caplog.records
    assert record.getMessage().startswith("renewing the lease on arm failed")
    assert record.exc_info is not None and record.exc_info[0] is KeyError


def test_the_same_owner_takes_its_lease_again_and_fences_the_older_engine(bench):
    async def story():
        async with bench.serving() as (_, url), bench.client(url) as old:
            goal = bench.goal(old, "go", x=1)
            async with bench.client(url) as new:
                stale = await old.follow(goal)
                fresh = await new.follow(bench.goal(new, "go", x=1))
                return stale, fresh, new.epoch("arm"), goal.epoch

    stale, fresh, newer, older = asyncio.run(story())

    assert (stale.error.name, stale.error.happened) == ("Lost", "no")
    assert fresh.state == "SUCCEEDED"
    assert newer > older


@pytest.mark.parametrize("then", ["finish", "cancel", "safe"])
def test_a_device_whose_engine_went_away_ends_in_its_safe_state(bench, then):
    async def story():
        async with bench.serving(contract={"on_lease_lapse": then}) as (server, url):
            async with bench.client(url, lease=False) as client:
                await client.take_lease("arm", "run-1", ttl_s=0.3)
                goal = bench.goal(client, "hold", seconds=1.0)
                following = asyncio.create_task(client.follow(goal))
                await bench.until(f"hold {goal.id}")
                following.cancel()
            await until(lambda: server.calm)
            return server.ledger.report(goal.id).state

    state = asyncio.run(story())

    assert state == ("SUCCEEDED" if then == "finish" else "CANCELED")
    assert bench.deeds()[1] == "arm safe"


def test_goals_go_on_through_a_broken_connection(bench):
    async def story():
        links = []
        async with bench.serving() as (_, url), bench.client(url, on_link=links.append) as client:
            goal = bench.goal(client, "hold", seconds=1.0)
            following = asyncio.create_task(client.follow(goal))
            await bench.until(f"hold {goal.id}")
            await client._link._sio.eio.ws.close()
            outcome = await following
            await until(lambda: links[-1])
            return outcome, links.copy()

    outcome, links = asyncio.run(story())

    assert outcome.state == "SUCCEEDED"
    assert links == [True, False, True]
    assert len([deed for deed in bench.deeds() if "hold" in deed]) == 1


def test_a_goal_whose_message_was_lost_is_sent_again_under_its_own_id(bench, monkeypatch):
    monkeypatch.setattr("labrun.drivers.client.goal_tracking.ANSWER_S", 0.3)

    async def story():
        async with bench.connected() as client:
            send, swallowed = client._link.send, []

            async def swallow_the_first(event, payload, answered):
                if event == "goal" and not swallowed:
                    return swallowed.append(payload) or True
                return await send(event, payload, answered)

            monkeypatch.setattr(client._link, "send", swallow_the_first)
            outcome = await client.follow(bench.goal(client, "go", x=1))
            return outcome, swallowed

    outcome, swallowed = asyncio.run(story())

    assert outcome.state == "SUCCEEDED"
    assert bench.deeds().count(f"arm go {swallowed[0]['id']}") == 1


def test_a_cancelled_goal_whose_message_was_lost_is_not_sent_again(bench, monkeypatch):
    monkeypatch.setattr("labrun.drivers.client.goal_tracking.ANSWER_S", 0.3)

    async def story():
        async with bench.connected() as client:
            send = client._link.send

            async def swallow_goals_and_cancels(event, payload, answered):
                swallow = event == "goal" or (event == "cancel" and not cancelled.is_set())
                return True if swallow else await send(event, payload, answered)

            cancelled = asyncio.Event()
            monkeypatch.setattr(client._link, "send", swallow_goals_and_cancels)
            goal = bench.goal(client, "go", x=1)
            following = asyncio.create_task(client.follow(goal))
            await asyncio.sleep(0)
            asking = asyncio.create_task(client.cancel(goal.id))
            await asyncio.sleep(0)
            cancelled.set()
            outcome = await following
            await asking
            return outcome, await client.query([goal.id])

    outcome, asked = asyncio.run(story())

    assert outcome.state == "CANCELED"
    assert next(iter(asked.goals.values())).state == "CANCELED"


def test_a_missed_heartbeat_makes_the_client_ask(bench, monkeypatch):
    monkeypatch.setattr("labrun.drivers.client.goal_tracking.BEAT_MISSED_S", 0.5)

    async def story():
        async with bench.connected() as client:
            client._link._sio.on("update", lambda data: None, namespace="/action")
            return await client.follow(bench.goal(client, "hold", seconds=1.0))

    assert asyncio.run(story()).state == "SUCCEEDED"


@pytest.mark.parametrize("trouble", ["its record cannot be read", "its end is not confirmed"])
def test_trouble_with_one_goal_does_not_cost_another_its_outcome(
    bench, monkeypatch, caplog, trouble
):
    monkeypatch.setattr("labrun.drivers.client.goal_tracking.ANSWER_S", 60)
    monkeypatch.setattr("labrun.drivers.client.goal_tracking.BEAT_MISSED_S", 60)

    async def story():
        async with (
            bench.serving(contract={"concurrent": True}) as (_, url),
            bench.client(url, lost_after_s=0) as client,
        ):
            link, watch = client._link, client._goal_watch
            call, send = link.call, link.send
            stray, good = bench.goal(client, "press"), bench.goal(client, "press")

            async def lose_the_stray(event, payload, answered):
                lost = event == "goal" and payload["id"] == stray.id
                return True if lost else await send(event, payload, answered)

            async def trouble_with_the_stray(event, request, *more):
                if event == "cancel":
                    raise LinkDown("no answer")
                answer = await call(event, request, *more)
                if event == "query" and trouble == "its record cannot be read":
                    answer["goals"] |= {i: {"state": 7} for i in request["ids"] if i == stray.id}
                return answer

            monkeypatch.setattr(link, "send", lose_the_stray)
            monkeypatch.setattr(link, "call", trouble_with_the_stray)
            link._sio.on("update", lambda data: None, namespace="/action")
            following = [asyncio.create_task(client.follow(goal)) for goal in (stray, good)]
            await bench.until(f"press {good.id}")
            while not (await client.query([good.id])).goals[good.id].ended:  # noqa: ASYNC110 - its updates are lost
                await asyncio.sleep(0.01)
            watch.doubt_all()
            return await asyncio.gather(*following)

    stray, good = asyncio.run(story())

    assert good.state == "SUCCEEDED"
    assert (stray.state, stray.error.happened) == ("LOST", "unknown")
    assert len(caplog.records) == (trouble == "its record cannot be read")


def test_after_a_kill_in_mid_goal_nobody_knows_and_nothing_is_done_twice(bench):
    port = free_port()

    async def story():
        async with own_process(bench, port=port) as first, bench.client(first.url) as client:
            goal = bench.goal(client, "press", seconds=30)
            epoch = client.epoch("arm")
            following = asyncio.create_task(client.follow(goal))
            await bench.until(f"press {goal.id}")
            await kill(first)
            async with own_process(bench, port=port):
                outcome = await following
                again = await client.follow(goal)
                await until(lambda: client.epoch("arm") > epoch)
                after = await client.follow(bench.goal(client, "go", x=1))
                return outcome, again, after

    outcome, again, after = asyncio.run(story())

    assert outcome == again
    assert (outcome.state, outcome.error.name) == ("ABORTED", "Lost")
    assert outcome.error.happened == "unknown"
    assert "during the action" in outcome.error.message
    assert after.state == "SUCCEEDED"
    assert len([deed for deed in bench.deeds() if "press" in deed]) == 1
    assert "arm safe" in bench.deeds()


def test_a_goal_that_never_reached_a_server_that_was_restarted_did_not_happen(bench):
    port = free_port()

    async def story():
        async with own_process(bench, port=port) as first, bench.client(first.url) as client:
            goal = bench.goal(client, "press")
            await kill(first)
            async with own_process(bench, port=port):
                outcome = await client.follow(goal)
                # A run that was put back from before does not know that it has sent it.
                return outcome, await client.follow(bench.goal(client, "press", id=goal.id))

    outcome, again = asyncio.run(story())

    assert (outcome.state, outcome.error.name, outcome.error.happened) == ("ABORTED", "Lost", "no")
    assert (again.state, again.error.happened) == ("CANCELED", "no")
    assert not [deed for deed in bench.deeds() if "press" in deed]


def test_a_goal_that_meets_a_server_which_is_ending_waits_for_its_next_boot(bench):
    port = free_port()

    async def story():
        slow = {"safe_s": 1.0}
        async with (
            own_process(bench, port=port, config=slow) as first,
            bench.client(first.url) as client,
        ):
            first.process.terminate()
            await bench.until("safe")
            following = asyncio.create_task(client.follow(bench.goal(client, "press")))
            await first.process.wait()
            waits = not following.done()
            async with own_process(bench, port=port):
                return waits, await following, await client.follow(bench.goal(client, "go", x=1))

    waits, outcome, after = asyncio.run(story())

    assert waits
    assert (outcome.error.name, outcome.error.happened) == ("Lost", "no")
    assert after.state == "SUCCEEDED"
    assert not [deed for deed in bench.deeds() if "press" in deed]


def test_a_goal_that_met_a_server_which_ended_for_good_did_not_happen(bench):
    async def story():
        async with (
            own_process(bench, config={"safe_s": 1.0}) as first,
            bench.client(first.url, lost_after_s=0.5) as client,
        ):
            first.process.terminate()
            await bench.until("safe")
            return await client.follow(bench.goal(client, "press"))

    outcome = asyncio.run(story())

    assert (outcome.error.name, outcome.error.happened) == ("Lost", "no")


def test_a_null_from_another_ledger_proves_nothing(bench):
    async def story():
        async with bench.connected() as client:
            goal = bench.goal(client, "press", boot="aaaaaaaaaaaa.bbbbbbbb")
            return await client.follow(goal)

    outcome = asyncio.run(story())

    assert (outcome.error.name, outcome.error.happened) == ("Lost", "unknown")


def test_an_outcome_of_an_earlier_boot_is_still_told(bench):
    async def story():
        async with bench.connected() as client:
            goal = bench.goal(client, "go", x=4)
            first = await client.follow(goal)
        async with bench.connected() as client:
            return first, await client.follow(goal)

    first, later = asyncio.run(story())

    assert later == first
    assert len([deed for deed in bench.deeds() if "go" in deed]) == 1


def test_a_new_engine_adopts_the_goal_of_the_one_before_it(bench):
    async def story():
        async with bench.serving() as (_, url):
            async with bench.client(url) as old:
                goal = bench.goal(old, "hold", seconds=1.0)
                following = asyncio.create_task(old.follow(goal))
                await bench.until(f"hold {goal.id}")
                following.cancel()
            async with bench.client(url) as new:
                return await new.follow(goal)

    outcome = asyncio.run(story())

    assert outcome.state == "SUCCEEDED"
    assert len([deed for deed in bench.deeds() if "hold" in deed]) == 1


def test_a_server_that_stays_away_makes_its_goals_lost(bench):
    async def story():
        async with (
            own_process(bench) as server,
            bench.client(server.url, lost_after_s=1.0) as client,
        ):
            goal = bench.goal(client, "press", seconds=30)
            following = asyncio.create_task(client.follow(goal))
            await bench.until(f"press {goal.id}")
            await kill(server)
            outcome = await following
            stop = await client.stop(timeout_s=0.2)
            with pytest.raises(ServerUnreachable):
                await client.query([goal.id])
            return outcome, stop

    outcome, stop = asyncio.run(story())

    assert (outcome.state, outcome.error.name) == ("LOST", "Lost")
    assert outcome.error.happened == "unknown"
    assert stop["arm"][0] is False


@pytest.mark.posix("Windows has no such signal")
def test_a_server_that_is_frozen_is_noticed_and_its_goal_goes_on_when_it_thaws(bench):
    async def story():
        links = []
        async with (
            own_process(bench) as server,
            bench.client(server.url, on_link=links.append) as client,
        ):
            goal = bench.goal(client, "hold", seconds=1.0)
            following = asyncio.create_task(client.follow(goal))
            await bench.until(f"hold {goal.id}")
            os.kill(server.pid, signal.SIGSTOP)
            await until(lambda: links[-1] is False)
            os.kill(server.pid, signal.SIGCONT)
            return await following

    assert asyncio.run(story()).state == "SUCCEEDED"


def test_a_server_that_is_not_there_is_said_with_address_and_reason():
    async def story():
        client = DeviceClient(f"http://127.0.0.1:{free_port()}")
        with pytest.raises(ServerUnreachable) as caught:
            await client.open(timeout_s=0.5)
        return client, caught.value

    client, fault = asyncio.run(story())

    assert fault.address == client.url
    assert client.url in str(fault)
    assert fault.reason in str(fault)


def test_a_refused_token_is_said(bench):
    async def story():
        async with bench.serving(token="secret") as (_, url):
            with pytest.raises(ServerUnreachable, match="the token is wrong"):
                await DeviceClient(url, "guess").open()
            async with bench.client(url, token="secret") as client:
                return await client.follow(bench.goal(client, "go", x=1))

    assert asyncio.run(story()).state == "SUCCEEDED"


def test_a_stop_says_for_each_device_whether_it_is_safe(bench):
    async def story():
        async with bench.connected() as client:
            return await client.stop(), await client.stop("leg")

    everything, unknown = asyncio.run(story())

    assert everything == {"arm": (True, "arm is in its safe state")}
    assert unknown == {"leg": (False, "there is no device 'leg' here; there is arm")}


def test_a_stop_that_the_network_has_lost_is_sent_again(bench, monkeypatch):
    monkeypatch.setattr("labrun.drivers.client.client.ANSWER_S", 0.0)
    monkeypatch.setattr("labrun.drivers.client.client.STOPS", 6000)
    lost = []

    async def story():
        async with bench.connected() as client:
            send = client._link.send

            async def losing(event, payload, answered=None):
                if event == "stop" and not lost:
                    lost.append(payload)
                    return True
                return await send(event, payload, answered)

            monkeypatch.setattr(client._link, "send", losing)
            return await client.stop("arm", timeout_s=600), len(lost)

    assert asyncio.run(story()) == ({"arm": (True, "arm is in its safe state")}, 1)


def test_status_reaches_whoever_wants_it(bench):
    async def story():
        told = asyncio.get_running_loop().create_future()

        def on_status(device, status):
            if not told.done():
                told.set_result((device, status))

        async with bench.serving() as (_, url), bench.client(url, on_status=on_status):
            return await told

    assert asyncio.run(story()) == ("arm", {"state": "idle"})


def test_a_closed_client_leaves_no_task(bench):
    async def story():
        async with own_process(bench) as server:
            async with bench.client(server.url) as client:
                following = asyncio.create_task(
                    client.follow(bench.goal(client, "hold", seconds=20))
                )
                await until(bench.deeds)
            outcome = await following
            return outcome, bench.tasks()

    outcome, left = asyncio.run(story())

    assert outcome.state == "LOST"
    assert left == []


@asynccontextmanager
async def slow_to_greet(url, delay_s):
    """An address whose server is reached late: every connection waits before its bytes pass."""
    host, port = url.removeprefix("http://").split(":")
    tasks = []

    async def pipe(source, sink):
        with contextlib.suppress(OSError):
            while data := await source.read(65536):
                sink.write(data)
                await sink.drain()
        sink.close()

    async def accept(reader, writer):
        tasks.append(asyncio.current_task())
        await asyncio.sleep(delay_s)
        there, back = await asyncio.open_connection(host, int(port))
        await asyncio.gather(pipe(reader, back), pipe(there, writer))

    server = await asyncio.start_server(accept, "127.0.0.1", 0)
    try:
        yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
    finally:
        server.close()
        await asyncio.gather(*tasks)


def test_a_server_that_is_there_and_slow_is_waited_for(bench, monkeypatch):
    monkeypatch.setattr("labrun.drivers.client.link.CONNECT_S", 0.2)

    async def story():
        async with bench.serving() as (_, url), slow_to_greet(url, 0.5) as slow:
            client = DeviceClient(slow)
            described = await client.open(60)
            await client.close()
            return described

    assert "arm" in asyncio.run(story()).devices


def test_a_greeting_that_breaks_off_is_no_refusal(bench, monkeypatch):
    monkeypatch.setattr("labrun.drivers.client.link.REACH_S", 0.0)
    left = [LinkDown("the connection broke")] * 2

    async def greet():
        if left:
            raise left.pop()

    async def story():
        async with bench.serving() as (_, url):
            link = Link(url, None, {}, greet, lambda: None)
            await link.open(60)
            await link.close()

    asyncio.run(story())

    assert left == []


@pytest.mark.parametrize(
    ("breaks", "why"), [(False, "Connection refused"), (True, "reset|Server disconnected")]
)
def test_who_refuses_the_connection_is_tried_again_and_told_in_the_systems_words(
    monkeypatch, breaks, why
):
    """A server that starts again beside us, or behind a tunnel, is there a moment later."""
    monkeypatch.setattr("labrun.drivers.client.link.REACH_S", 0.0)
    calls = []

    async def hang_up(_, writer):
        calls.append(1)
        writer.close()

    async def story():
        door = await asyncio.start_server(hang_up, "127.0.0.1", 0)
        url = f"http://127.0.0.1:{door.sockets[0].getsockname()[1]}"
        if not breaks:
            door.close()
        link = Link(url, None, {}, asyncio.Event().wait, lambda: None)
        with pytest.raises(ServerUnreachable, match=why) as told:
            await link.open(60)
        door.close()
        return told.value

    assert not isinstance(asyncio.run(story()), Denied)


def test_a_server_that_is_up_a_moment_later_is_reached(bench, monkeypatch):
    monkeypatch.setattr("labrun.drivers.client.link.REACH_S", 600.0)
    port = free_port()

    async def greet():
        pass

    async def story():
        link = Link(f"http://127.0.0.1:{port}", None, {}, greet, lambda: None)
        opening = asyncio.create_task(link.open(600))
        while not link.refusal:  # noqa: ASYNC110
            await asyncio.sleep(0.01)
        async with bench.serving(port=port):
            await opening
            await link.close()
        return link.refusal

    assert asyncio.run(story()) == "Connection refused"


@pytest.mark.posix("Windows has no such signal")
def test_a_server_that_never_greets_is_given_up_after_the_time_that_was_given(bench, monkeypatch):
    monkeypatch.setattr("labrun.drivers.client.link.REACH_S", 0.1)

    async def story():
        async with own_process(bench) as server:
            os.kill(server.pid, signal.SIGSTOP)
            try:
                with pytest.raises(ServerUnreachable, match=r"no response within 0\.5 s"):
                    await DeviceClient(server.url).open(0.5)
            finally:
                os.kill(server.pid, signal.SIGCONT)

    asyncio.run(story())


def test_a_client_that_is_closed_in_mid_handshake_leaves_no_socket(monkeypatch):
    monkeypatch.setattr("labrun.drivers.client.link.REACH_S", 0.1)
    hung_up = asyncio.Event()

    async def never_greet(request):
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        await socket.receive()
        hung_up.set()
        return socket

    async def story():
        app = web.Application()
        app.router.add_get("/socket.io/", never_greet)
        runner = web.AppRunner(app)
        await runner.setup()
        site = web.SockSite(runner, listening := socket.create_server(("127.0.0.1", 0)))
        await site.start()
        try:
            url = f"http://127.0.0.1:{listening.getsockname()[1]}"
            while not hung_up.is_set():  # a busy machine may not have come to the handshake
                with pytest.raises(ServerUnreachable, match="no response"):
                    await DeviceClient(url).open(0.3)
                await asyncio.sleep(0.1)
        finally:
            await runner.cleanup()

    assert unclosed_after(story()) == []


@pytest.mark.posix("Windows has no such signal")
def test_a_client_that_is_cancelled_while_it_hangs_up_leaves_no_socket(bench):
    async def story():
        async with own_process(bench) as server:
            client = DeviceClient(server.url)
            await client.open(60)
            os.kill(server.pid, signal.SIGSTOP)
            try:
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(0.1):
                        await client.close()
            finally:
                os.kill(server.pid, signal.SIGCONT)

    assert unclosed_after(story()) == []


def unclosed_after(story):
    """What Python and aiohttp complain about when a story is over and its memory is freed."""
    with warnings.catch_warnings(record=True) as left:
        warnings.simplefilter("always")
        asyncio.run(story, debug=True)
        gc.collect()
    return [str(warning.message) for warning in left]


def test_an_argument_that_is_no_number_is_refused_before_it_is_sent(bench):
    async def story():
        async with bench.serving() as (_, url), bench.client(url) as client:
            outcome = await client.follow(goal := bench.goal(client, "go", x=math.nan))
            return outcome.error, await client.knows(goal.id)

    error, known = asyncio.run(story())

    assert (error.name, error.happened, known) == ("Rejected", "no", False)
    assert error.message == "arm.go.x: nan is not a number that JSON can represent"
