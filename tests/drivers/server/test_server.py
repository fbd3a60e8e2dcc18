"""Every row of the wire's table of events, as a stranger's Socket.IO client sees it."""

import asyncio
from hashlib import sha256

import pytest
import socketio


def test_describe_says_what_is_served_and_under_which_boot(bench):
    async def story():
        async with bench.serving(limits={"x": {"maximum": 5}}) as (_, url), bench.raw(url) as raw:
            return await raw.call("describe")

    said = asyncio.run(story())

    assert said["ok"]
    assert said["boot"].startswith(said["ledger"])
    arm = said["devices"]["arm"]
    assert arm["contract"]["type"] == "scripted@1"
    assert arm["driver"] == "Scripted"
    assert arm["versions"] == {"firmware": "1.0"}
    assert arm["limits"] == {"x": {"minimum": None, "maximum": 5}}
    assert arm["status"] == {"state": "idle"}


def test_a_lease_gives_an_epoch_and_is_refused_to_others_with_the_holder(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            mine = await raw.call("lease", device="arm", owner="run-1", ttl_s=30.0)
            theirs = await raw.call("lease", device="arm", owner="page", ttl_s=30.0)
            again = await raw.call("lease", device="arm", owner="run-1", ttl_s=30.0)
            return mine, theirs, again

    mine, theirs, again = asyncio.run(story())

    assert mine["ok"]
    assert (theirs["ok"], theirs["code"], theirs["holder"]) == (False, "HELD", "run-1")
    assert again["epoch"] > mine["epoch"]


def test_a_released_lease_is_free_for_others(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            mine = await raw.call("lease", device="arm", owner="run-1", ttl_s=30.0)
            gone = await raw.call("release", device="arm", owner="run-1", epoch=mine["epoch"])
            theirs = await raw.call("lease", device="arm", owner="page", ttl_s=30.0)
            return gone, theirs

    gone, theirs = asyncio.run(story())

    assert gone["released"]
    assert theirs["ok"]


def test_a_goal_is_acknowledged_at_once_and_its_end_is_told(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            answer = await raw.call("goal", **await raw.leased())
            return answer, await raw.update("g1", "SUCCEEDED")

    answer, update = asyncio.run(story())

    assert answer["ok"]
    assert answer["state"] == "EXECUTING"
    assert update["result"] == {"x": 1}
    assert update["boot"]
    assert update["seq"] > answer["seq"]


def test_the_same_id_is_the_same_goal_and_never_executes_twice(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            goal = await raw.leased()
            await raw.call("goal", **goal)
            await raw.update("g1", "SUCCEEDED")
            again = await raw.call("goal", **goal)
            await raw.call("release", device="arm", owner="raw")
            return (
                again,
                await raw.call("goal", **goal),
                await raw.call("goal", **{**goal, "id": "g2"}),
            )

    again, later, other = asyncio.run(story())

    for copy in (again, later):
        assert (copy["dup"], copy["state"], copy["result"]) == (True, "SUCCEEDED", {"x": 1})
    assert other["code"] == "STALE_EPOCH"
    assert bench.deeds().count("arm go g1") == 1


@pytest.mark.parametrize(
    ("part", "code", "words"),
    [
        ({"boot": "other.1"}, "STALE_BOOT", "restarted"),
        ({"epoch": 0}, "STALE_EPOCH", "raw holds it now"),
        ({"params": {"x": 11}}, "INVALID", "arm.go.x: 11 mm is above the maximum, 10 mm"),
        ({"params": {"x": "far"}}, "INVALID", "arm.go.x: 'far' is not of type 'number'"),
        ({"params": {}}, "INVALID", "arm.go: 'x' is a required property"),
        ({"params": {"x": 1, "y": 2}}, "INVALID", "'y' was unexpected"),
        ({"action": "fly"}, "INVALID", "arm has no action 'fly'"),
        ({"device": "leg"}, "UNKNOWN_DEVICE", "there is no device 'leg' here; there is arm"),
        ({"epoch": "one"}, "INVALID", "epoch: "),
        ({"id": ""}, "INVALID", "id: "),
    ],
)
def test_a_goal_that_must_not_start_is_refused_with_a_sentence(bench, part, code, words):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            answer = await raw.call("goal", **await raw.leased(**part))
            return answer, await raw.call("query", ids=["g1"])

    answer, asked = asyncio.run(story())

    assert (answer["ok"], answer["code"]) == (False, code)
    assert words in answer["message"]
    assert asked["goals"]["g1"] is None
    assert not [deed for deed in bench.deeds() if "go" in deed]


def test_a_goal_without_anybodys_lease_is_refused(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            boot = (await raw.call("describe"))["boot"]
            goal = {"id": "g1", "device": "arm", "action": "go", "params": {"x": 1}}
            return await raw.call("goal", **goal, boot=boot, epoch=0)

    answer = asyncio.run(story())

    assert answer["code"] == "STALE_EPOCH"
    assert "no lease on arm" in answer["message"]


def test_the_limits_of_the_bench_narrow_the_contract(bench):
    async def story():
        async with bench.serving(limits={"x": [2, 5]}) as (_, url), bench.raw(url) as raw:
            high = await raw.call("goal", **await raw.leased(params={"x": 6}))
            low = await raw.call("goal", **await raw.leased(params={"x": 1}))
            return high, low

    high, low = asyncio.run(story())

    assert "above the maximum, 5 mm" in high["message"]
    assert "below the minimum, 2 mm" in low["message"]


def test_a_busy_device_refuses_a_second_goal_and_a_concurrent_one_takes_it(bench):
    async def story(concurrent):
        async with (
            bench.serving(contract={"concurrent": concurrent}) as (_, url),
            bench.raw(url) as raw,
        ):
            goal = await raw.leased(action="hold", params={"seconds": 20})
            await raw.call("goal", **goal)
            return await raw.call("goal", **{**goal, "id": "g2", "params": {"seconds": 0}})

    single, concurrent = asyncio.run(story(False)), asyncio.run(story(True))

    assert single["code"] == "BUSY"
    assert "arm is busy with g1" in single["message"]
    assert concurrent["ok"]


def test_cancel_ends_a_goal_that_may_be_cancelled(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            await raw.call("goal", **await raw.leased(action="hold", params={"seconds": 20}))
            await bench.until("hold g1")
            answer = await raw.call("cancel", id="g1")
            return answer, await raw.update("g1", "CANCELED")

    answer, update = asyncio.run(story())

    assert (answer["ok"], answer["state"]) == (True, "CANCELING")
    assert "error" not in update


def test_cancel_lets_what_cannot_be_cancelled_go_on_to_its_end(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            await raw.call("goal", **await raw.leased(action="press", params={"seconds": 0.3}))
            answer = await raw.call("cancel", id="g1")
            return answer, await raw.update("g1", "SUCCEEDED")

    answer, update = asyncio.run(story())

    assert (answer["ok"], answer["state"]) == (True, "EXECUTING")
    assert update["result"] == {}


def test_a_cancel_of_a_goal_of_an_earlier_boot_that_is_not_known_here_denies_nothing(bench):
    async def scenario():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            answer = await raw.call("cancel", id="g1", boot="another.boot")
            return answer, await raw.call("query", ids=["g1"])

    answer, queried = asyncio.run(scenario())
    assert (answer["ok"], answer["code"]) == (False, "STALE_BOOT")
    assert queried["goals"] == {"g1": None}


def test_cancel_before_its_goal_leaves_a_tombstone(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            goal = await raw.leased()
            cancelled = await raw.call("cancel", id="g1")
            return cancelled, await raw.call("goal", **goal)

    cancelled, late = asyncio.run(story())

    assert (cancelled["ok"], cancelled["state"]) == (True, "CANCELED")
    assert (late["ok"], late["dup"], late["state"]) == (True, True, "CANCELED")
    assert late["error"]["happened"] == "no"
    assert "arm go g1" not in bench.deeds()


def test_query_tells_the_truth_by_id_and_since_a_change(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            goal = await raw.leased()
            await raw.call("goal", **goal)
            first = await raw.update("g1", "SUCCEEDED")
            await raw.call("goal", **{**goal, "id": "g2"})
            await raw.update("g2", "SUCCEEDED")
            by_id = await raw.call("query", ids=["g1", "g9"])
            return by_id, await raw.call("query", since=first["seq"])

    by_id, since = asyncio.run(story())

    assert by_id["boot"].startswith(by_id["ledger"])
    assert by_id["goals"]["g1"]["result"] == {"x": 1}
    assert by_id["goals"]["g9"] is None
    assert list(since["goals"]) == ["g2"]


def test_stop_needs_no_lease_ends_what_runs_and_confirms_the_safe_state(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw, bench.raw(url) as passer_by:
            await raw.call("goal", **await raw.leased(action="hold", params={"seconds": 20}))
            await bench.until("hold g1")
            answer = await passer_by.call("stop", device="arm")
            update = await raw.update("g1", "CANCELED")
            return answer, update

    answer, update = asyncio.run(story())

    assert (answer["ok"], answer["safe"]) == (True, True)
    assert answer["message"] == "arm is in its safe state"
    assert update["state"] == "CANCELED"
    assert "arm safe" in bench.deeds()


def test_after_a_strangers_stop_the_holder_must_take_its_lease_anew(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw, bench.raw(url) as passer_by:
            goal = await raw.leased()
            await passer_by.call("stop")
            refused = await raw.call("goal", **goal)
            renewal = {"device": "arm", "owner": "raw", "ttl_s": 30.0, "epoch": goal["epoch"]}
            await raw.call("lease", **renewal)
            still = await raw.call("goal", **goal | {"id": "g2"})
            mine = await raw.leased()
            return refused, still, await raw.call("goal", **mine), mine["epoch"] - goal["epoch"]

    refused, still, anew, epochs = asyncio.run(story())

    assert refused["code"] == still["code"] == "STOPPED"
    assert "stopped by another client" in refused["message"]
    assert anew["ok"]
    assert epochs == 2  # the gap tells whoever resumes later that somebody else intervened


def test_stop_breaks_off_what_cannot_be_cancelled_and_says_that_nobody_knows(bench):
    async def story():
        quickly = bench.serving(contract={"cancel_grace": "0.1 s"})
        async with quickly as (_, url), bench.raw(url) as raw:
            await raw.call("goal", **await raw.leased(action="press", params={"seconds": 30}))
            await bench.until("press g1")
            await raw.call("stop")
            return await raw.update("g1", "ABORTED")

    update = asyncio.run(story())

    assert update["error"]["name"] == "Stopped"
    assert update["error"]["happened"] == "unknown"
    assert bench.deeds().count("arm safe") >= 2


@pytest.mark.parametrize(
    ("config", "words"),
    [({"safe_s": 1.0}, "within 0.2 s"), ({"safe_fails": True}, "RuntimeError: the brake is worn")],
)
def test_a_stop_that_is_not_confirmed_says_so_in_time(bench, config, words):
    async def story():
        async with bench.serving(config=config) as (_, url), bench.raw(url) as raw:
            return await raw.call("stop", timeout_s=0.2)

    answer = asyncio.run(story())

    assert (answer["ok"], answer["safe"]) == (True, False)
    assert words in answer["message"]


def test_a_goal_that_comes_while_the_device_is_made_safe_waits_for_it(bench):
    async def story():
        async with bench.serving(config={"safe_s": 0.5}) as (_, url), bench.raw(url) as raw:
            goal = await raw.leased()
            stopping = asyncio.create_task(raw.call("stop"))
            await bench.until("safe")
            accepted = await raw.call("goal", **goal)
            waiting = await raw.call("goal", **{**goal, "id": "g2"})
            await raw.update("g1", "SUCCEEDED")
            await stopping
            return accepted, waiting

    accepted, waiting = asyncio.run(story())

    assert accepted["state"] == "ACCEPTED"
    assert waiting["code"] == "BUSY"


def test_a_goal_cancelled_while_it_waits_never_starts(bench):
    async def story():
        async with bench.serving(config={"safe_s": 0.5}) as (_, url), bench.raw(url) as raw:
            goal = await raw.leased(action="press", params={})
            stopping = asyncio.create_task(raw.call("stop"))
            await bench.until("safe")
            await raw.call("goal", **goal)
            await raw.call("cancel", id="g1")
            update = await raw.update("g1", "CANCELED")
            await stopping
            return update

    update = asyncio.run(story())

    assert update["error"]["name"] == "NEVER_STARTED"
    assert "arm press g1" not in bench.deeds()


def test_a_goal_under_way_is_heard_of_and_says_how_far_it_is(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            await raw.call("goal", **await raw.leased(action="hold", params={"seconds": 2.5}))
            await raw.update("g1", "SUCCEEDED")
            return [data for event, data in raw.events if event == "update"]

    updates = asyncio.run(story())

    assert [u["state"] for u in updates[:3]] == ["EXECUTING"] * 3
    assert (updates[0]["progress"], updates[0]["message"]) == (0.5, "half way")
    assert [u["seq"] for u in updates] == sorted(u["seq"] for u in updates)


def test_status_comes_by_itself(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            return await raw.status()

    assert asyncio.run(story()) == {"device": "arm", "state": "idle"}


def test_files_go_to_who_follows_the_goal_and_to_nobody_else(bench):
    data = b"4.2,17\n" * 60_000
    file = {"path": "in.csv", "sha256": sha256(data).hexdigest(), "data": data}

    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw, bench.raw(url) as passer_by:
            params = {"source": "in.csv", "file": "out.csv"}
            goal = await raw.leased(action="copy", params=params, files={"source": file})
            await raw.call("goal", **goal)
            mine = await raw.update("g1", "SUCCEEDED")
            return mine, await passer_by.update("g1", "SUCCEEDED")

    mine, theirs = asyncio.run(story())

    assert mine["files"]["file"]["data"] == data[::-1]
    assert "files" not in theirs


def test_an_exception_in_the_server_is_an_answer(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            return await raw.call("query", ids=7), await raw.call("dance")

    wrong, unknown = asyncio.run(story())

    assert (wrong["ok"], wrong["code"]) == (False, "EXCEPTION")
    assert "TypeError" in wrong["message"]
    assert unknown["message"] == "there is no request 'dance'"


@pytest.mark.parametrize(("given", "words"), [(None, "required"), ("guess", "wrong")])
def test_a_wrong_or_missing_token_is_refused_at_connect(bench, given, words):
    async def story():
        async with bench.serving(token="secret") as (_, url):
            async with bench.raw(url, "secret") as raw:
                assert (await raw.call("describe"))["ok"]
            said = []
            sio = socketio.AsyncClient(reconnection=False, handle_sigint=False)
            sio.on("connect_error", said.append, namespace="/action")
            auth = None if given is None else {"token": given}
            with pytest.raises(socketio.exceptions.ConnectionError):
                await sio.connect(url, auth=auth, transports=["websocket"], namespaces=["/action"])
            return said

    said = asyncio.run(story())

    assert words in said[0]["message"]


def test_guesses_at_the_token_are_slow_however_many_come_at_once(bench, monkeypatch):
    monkeypatch.setattr("labrun.drivers.server.gate.GUESS_S", 0.3)

    async def story():
        async with bench.serving(token="a-secret-of-16-chars") as (server, url):
            looked_at = []
            look = server._brake.look

            async def looking(given):
                began = asyncio.get_running_loop().time()
                answer = await look(given)
                looked_at.append(asyncio.get_running_loop().time() - began)
                return answer

            server._brake.look = looking

            async def guess(number):
                with pytest.raises(socketio.exceptions.ConnectionError):
                    async with bench.raw(url, f"guess-{number}"):
                        pass

            await asyncio.gather(*(guess(number) for number in range(8)))
            async with bench.raw(url, "a-secret-of-16-chars") as raw:
                return looked_at, (await raw.call("describe"))["ok"]

    looked_at, after = asyncio.run(story())

    assert after
    assert len(looked_at) == 9
    assert 1 <= len([s for s in looked_at if s >= 0.3]) <= 8  # the others were not looked at


def test_goals_survive_the_connection_that_sent_them(bench):
    async def story():
        async with bench.serving() as (_, url):
            async with bench.raw(url) as raw:
                await raw.call("goal", **await raw.leased(action="hold", params={"seconds": 0.5}))
            async with bench.raw(url) as raw:
                await raw.call("query", ids=["g1"])
                return await raw.update("g1", "SUCCEEDED")

    assert asyncio.run(story())["result"] == {"held": 0.5}


def test_a_server_that_ends_leaves_its_devices_safe_and_its_goals_told(bench):
    async def story():
        async with bench.serving() as (server, url):
            async with bench.raw(url) as raw:
                await raw.call("goal", **await raw.leased(action="hold", params={"seconds": 20}))
                await bench.until("hold g1")
            assert not server.calm
        return bench.tasks()

    left = asyncio.run(story())

    assert left == []
    assert bench.deeds()[-2:] == ["arm safe", "arm close"]


@pytest.mark.parametrize(
    ("headers", "words"),
    [
        ({"Host": "evil.example"}, "this server is not 'evil.example'"),
        ({"Host": "evil.example", "Origin": "http://evil.example"}, "this server is not"),
        ({"Host": "127.0.0.1.evil.example:80"}, "this server is not"),
        ({"Host": "["}, "this server is not '['"),
        ({"Origin": "http://evil.example"}, "pages of other sites"),
        ({"Origin": "http://127.0.0.1:1"}, "pages of other sites"),
        ({"Origin": "null"}, "pages of other sites"),
        ({"X-Forwarded-Host": "evil.example", "Origin": "http://evil.example"}, "pages of other"),
    ],
)
def test_a_browser_that_was_led_here_by_another_site_does_nothing(bench, headers, words):
    async def story():
        async with bench.serving() as (_, url):
            sio = socketio.AsyncClient(reconnection=False, handle_sigint=False)
            said = []
            sio.on("connect_error", said.append, namespace="/action")
            try:
                with pytest.raises(socketio.exceptions.ConnectionError):
                    await sio.connect(
                        url, headers=headers, transports=["websocket"], namespaces=["/action"]
                    )
            finally:
                await sio.disconnect()
            return said

    assert words in str(asyncio.run(story()))


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1:4101", "[::1]:4101"])
def test_a_program_may_use_any_name_of_this_machine(bench, host):
    async def story():
        async with bench.serving() as (_, url):
            sio = socketio.AsyncClient(reconnection=False, handle_sigint=False)
            await sio.connect(
                url, headers={"Host": host}, transports=["websocket"], namespaces=["/action"]
            )
            described = await sio.call("describe", {}, namespace="/action")
            await sio.disconnect()
            return described

    assert asyncio.run(story())["ok"]


def test_one_whose_instrument_is_out_of_reach_is_refused_with_the_reason_until_it_can_be_opened(
    bench, monkeypatch
):
    monkeypatch.setattr("labrun.drivers.server.server.OPEN_AGAIN_S", 0.01)

    async def story():
        lent, opened = bench.serving(config={"missing": True}, patient=True), asyncio.Event()
        async with lent as (server, url), bench.raw(url) as raw:
            server.on_opened = lambda name: opened.set()
            said = [
                await raw.call("lease", device="arm", owner="raw", ttl_s=30.0),
                await raw.call("goal", id="g0", device="arm", boot="", epoch=1, action="go", params={}),
                await raw.call("goal", id="g0", device="arm", boot=server.ledger.boot, epoch=1,
                               action="go", params={"x": 1}),
                await raw.call("stop"),
                await raw.call("stop", device="arm"),
            ]  # fmt: skip
            described = (await raw.call("describe"))["devices"]["arm"]
            (bench.folder / "world").mkdir(exist_ok=True)
            (bench.folder / "world" / "plugged").touch()
            await opened.wait()
            fault = (await raw.call("describe"))["devices"]["arm"]["status"].get("fault")
            late = await raw.call("goal", id="g0", device="arm", boot=server.ledger.boot, epoch=1,
                                  action="go", params={"x": 1})  # fmt: skip
            done = await raw.call("goal", **await raw.leased())
            await raw.update("g1", "SUCCEEDED")
        return said, described, fault, late, done["ok"]

    (lease, stale, goal, stop, stop_arm), described, fault, late, done = asyncio.run(story())

    words = "device arm cannot be opened: nothing answers on /dev/nowhere; its server tries again"
    assert (lease["code"], goal["code"], stale["code"]) == ("REJECTED", "REJECTED", "STALE_BOOT")
    assert lease["message"].startswith(words) and goal["message"].startswith(words)
    assert stop["safe"] is stop_arm["safe"] is False
    assert stop_arm["devices"]["arm"]["message"].startswith(f"arm may not be safe: {words}")
    assert described["status"]["fault"].startswith(words)
    assert described["contract"]["type"] == "scripted@1"
    assert (fault, late["code"], done) == (None, "STALE_EPOCH", True)
    assert len([deed for deed in bench.deeds() if deed.startswith("arm go")]) == 1
