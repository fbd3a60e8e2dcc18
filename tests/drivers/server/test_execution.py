"""However a driver's action ends, its goal ends with words that the engine can go by."""

import asyncio

import pytest

from labrun.drivers.server.ledger import LedgerFault


def follow(bench, action, **params):
    async def story():
        async with bench.connected() as client:
            return await client.follow(bench.goal(client, action, **params))

    return asyncio.run(story())


def test_an_error_of_the_contract_says_whether_the_action_happened(bench):
    error = follow(bench, "fail").error

    assert (error.name, error.message, error.happened) == ("Jammed", "the drawer is stuck", "no")


def test_the_drivers_own_word_on_what_happened_counts_more(bench):
    assert follow(bench, "fail", happened="yes").error.happened == "yes"


def test_an_error_that_the_contract_does_not_declare_is_passed_on_and_unknown(bench):
    error = follow(bench, "fail", error="Meltdown").error

    assert (error.name, error.happened) == ("Meltdown", "unknown")


@pytest.mark.parametrize("happened", ["no", "yes", "unknown"])
def test_what_made_an_error_unknown_is_in_the_log(bench, happened, caplog):
    follow(bench, "fail", happened=happened)

    assert ("LookupError: no rail 7" in caplog.text) == (happened == "unknown")


def test_a_driver_that_raises_is_a_fault_and_nobody_knows(bench):
    outcome = follow(bench, "crash")

    assert (outcome.state, outcome.error.name) == ("ABORTED", "Fault")
    assert outcome.error.message == "arm.crash: ZeroDivisionError: division by zero"
    assert outcome.error.happened == "unknown"


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("text", "the answer of arm.answer.value: 'text' is not of type 'number'"),
        ("nan", "the answer of arm.answer.value: nan is not a number that JSON can represent"),
    ],
)
def test_a_wrong_answer_is_a_fault_that_names_the_field(bench, value, words):
    error = follow(bench, "answer", value=value).error

    assert (error.name, error.message) == ("Fault", words)
    assert error.happened == "unknown"  # the driver did it: a second time would be one too many


def test_a_driver_that_does_not_heed_a_cancel_is_broken_off_after_the_contracts_grace(bench):
    states = []

    async def story():
        async with bench.connected(contract={"cancel_grace": "0.1 s"}) as client:
            goal = bench.goal(client, "sleep_through", seconds=30)
            following = asyncio.create_task(client.follow(goal, lambda r: states.append(r.state)))
            await bench.until(f"sleep_through {goal.id}")
            await client.cancel(goal.id)
            outcome = await following
            return outcome, await client.follow(bench.goal(client, "go", x=1))

    outcome, after = asyncio.run(story())

    assert (outcome.state, outcome.error) == ("CANCELED", None)
    assert "CANCELING" in states
    assert after.state == "SUCCEEDED"


def test_a_late_success_counts_after_a_cancel_and_no_later_stop_has_cut_it_short(bench):
    async def story():
        async with bench.connected() as client:
            goal = bench.goal(client, "sleep_through", seconds=0.5)
            following = asyncio.create_task(client.follow(goal))
            await bench.until(f"sleep_through {goal.id}")
            await client.cancel(goal.id)
            await client.stop("arm")
            return await following

    outcome = asyncio.run(story())

    assert (outcome.state, outcome.error) == ("SUCCEEDED", None)


def test_a_goal_is_refused_and_not_started_while_the_ledger_cannot_be_written(bench):
    async def story():
        async with bench.serving() as (server, url), bench.client(url) as client:
            pages = server.ledger._disk.execute("PRAGMA page_count").fetchone()[0]
            server.ledger._disk.execute(f"PRAGMA max_page_count = {pages}")
            outcomes = []
            # The last page takes some rows yet; only what is on disk may run.
            for n in range(200):
                goal = bench.goal(client, "answer", id=f"{n}{'x' * 900}", value=1)
                outcomes.append(await asyncio.wait_for(client.follow(goal), 500))
                if outcomes[-1].error is not None:
                    break
            return outcomes[-1]

    outcome = asyncio.run(story())

    assert (outcome.error.name, outcome.error.happened) == ("Rejected", "no")
    assert "database or disk is full; nothing was started" in outcome.error.message


def test_an_outcome_that_cannot_be_written_is_told_and_kept_and_nothing_begins_until_it_is(bench):
    async def story():
        async with bench.serving() as (server, url), bench.client(url) as client:
            end, full = server.ledger.end, True

            def write(*args):
                if full:
                    raise LedgerFault("the ledger cannot be written: the disk is full")
                return end(*args)

            server.ledger.end = write
            first = bench.goal(client, "go", x=1)
            told = await client.follow(first)
            asked = (await client.query([first.id])).goals[first.id]
            refused = await client.follow(bench.goal(client, "go", x=2))
            full = False
            async with asyncio.timeout(500):
                while server.devices["arm"].running:  # noqa: ASYNC110 - the next attempt writes it
                    await asyncio.sleep(0.02)
            return (
                told,
                asked,
                refused,
                server.ledger.report(first.id),
                await client.follow(bench.goal(client, "go", x=3)),
            )

    told, asked, refused, written, after = asyncio.run(story())

    assert told.state == asked.state == written.state == after.state == "SUCCEEDED"
    assert told.result == asked.result == written.result == {"x": 1}
    assert (refused.error.name, refused.error.happened) == ("Rejected", "no")
    assert "the disk is full; nothing begins until the end of" in refused.error.message


def test_a_driver_that_says_odd_things_still_comes_to_an_end(bench):
    outcome = follow(bench, "mumble")

    assert (outcome.state, outcome.error.name, outcome.error.happened) == (
        "ABORTED",
        "7",
        "unknown",
    )
    assert outcome.error.message == "['a', 'list']"


ODD = {
    "tuple as key": "the answer of arm.odd.peaks: (1, 2) cannot be a name in JSON",
    "number as key": "the answer of arm.odd: 7 cannot be a name in JSON",
    "half a character": "the answer of arm.odd.path: '\\udcff' is not Unicode text",
    "half a character as error": "arm.odd: PydanticSerializationError: ",
    "endless": "arm.odd: RecursionError: maximum recursion depth exceeded",
    "exit": "arm.odd: SystemExit: 3",
    "many digits": "the answer of arm.odd.n: too many digits",
    "feedback": "arm.odd: TypeError: must be real number, not str",
}


@pytest.mark.parametrize("kind", ODD)
def test_however_oddly_an_action_ends_its_client_hears_it_and_the_server_goes_on(bench, kind):
    async def story():
        async with bench.connected() as client, asyncio.timeout(500):
            outcome = await client.follow(bench.goal(client, "odd", kind=kind))
            return outcome.error, await client.follow(bench.goal(client, "go", x=1))

    error, after = asyncio.run(story())

    assert (error.name, error.happened) == ("Fault", "unknown")
    assert error.message.startswith(ODD[kind])
    assert after.state == "SUCCEEDED"


@pytest.mark.parametrize("broken", ["_perform", "ledger"])
def test_a_fault_of_the_servers_own_ends_the_goal_that_met_it(bench, broken):
    async def story():
        async with bench.serving() as (server, url), bench.client(url) as client:
            place = server.devices["arm"] if broken == "_perform" else server.ledger
            name = "_perform" if broken == "_perform" else "end"
            whole = getattr(place, name)
            setattr(place, name, lambda *args: 1 / 0)
            async with asyncio.timeout(500):
                outcome = await client.follow(bench.goal(client, "go", x=1))
                setattr(place, name, whole)
                while server.devices["arm"].running:  # noqa: ASYNC110 - it is written once it can be
                    await asyncio.sleep(0.02)
                return outcome.error, await client.follow(bench.goal(client, "go", x=1))

    error, after = asyncio.run(story())

    assert (error.name, error.happened) == ("Fault", "unknown")
    assert error.message == "arm.go: ZeroDivisionError: division by zero"
    assert after.state == "SUCCEEDED"


@pytest.mark.parametrize("action", ["hold", "sleep_through"])
def test_a_goal_past_its_deadline_is_ended_by_its_server_also_without_an_engine(bench, action):
    async def story():
        async with bench.serving(contract={"cancel_grace": "0.1 s"}) as (_, url):
            async with bench.raw(url) as raw:
                goal = await raw.leased(action=action, params={"seconds": 30}, timeout_s=0.3)
                await raw.call("goal", **goal)
            async with bench.client(url, lease=False) as client:  # its engine is gone
                asked = bench.goal(client, action, id="g1", seconds=30)
                async with asyncio.timeout(500):
                    return await client.follow(asked, send=False)

    outcome = asyncio.run(story())

    assert (outcome.state, outcome.error.name) == ("ABORTED", "Timeout")
    assert outcome.error.message == f"arm.{action} took longer than 0.3 s"
    assert outcome.error.happened == "unknown"


def test_past_its_deadline_what_cannot_be_cancelled_goes_on_and_a_cancel_stays_a_cancel(bench):
    async def story():
        async with bench.serving() as (_, url), bench.raw(url) as raw:
            goal = await raw.leased(action="press", params={"seconds": 0.6}, timeout_s=0.2)
            await raw.call("goal", **goal)
            pressed = await raw.update("g1", "SUCCEEDED")
            goal |= {"id": "g2", "action": "hold", "params": {"seconds": 30}, "timeout_s": 30}
            await raw.call("goal", **goal)
            await raw.call("cancel", id="g2")
            refused = await raw.call("goal", **{**goal, "id": "g3", "timeout_s": float("nan")})
            return pressed, await raw.update("g2", "CANCELED"), refused

    pressed, cancelled, refused = asyncio.run(story())

    assert "error" not in pressed and "error" not in cancelled
    assert (refused["code"], "timeout_s" in refused["message"]) == ("INVALID", True)


def test_a_goal_that_waits_past_its_deadline_has_certainly_not_happened(bench):
    async def story():
        async with bench.serving(config={"safe_s": 1.5}) as (_, url), bench.raw(url) as raw:
            goal = await raw.leased(timeout_s=0.2)
            stopping = asyncio.create_task(raw.call("stop"))
            await bench.until("safe")
            await raw.call("goal", **goal)
            late = await raw.update("g1", "ABORTED")
            await stopping
            return late["error"]

    error = asyncio.run(story())

    assert (error["name"], error["happened"]) == ("Timeout", "no")
    assert error["message"] == "arm.go took longer than 0.2 s, and had not begun"
    assert "arm go g1" not in bench.deeds()


@pytest.mark.parametrize(
    ("door", "words"),
    [
        ("open", "door is 'open' and must be 'closed'"),
        ("away", "door is not reported and must be 'closed'"),
        ("dead", "nobody knows whether door is 'closed': OSError: the door does not answer"),
    ],
)
def test_an_action_whose_interlock_does_not_hold_is_refused(bench, door, words):
    actions = bench.contract()["actions"]
    actions["go"]["interlock"] = {"door": "closed"}

    async def story():
        (bench.folder / "world").mkdir()
        (bench.folder / "world" / "door").write_text("closed")
        async with bench.connected(contract={"actions": actions}) as client:
            first = await client.follow(bench.goal(client, "go", x=1))
            (bench.folder / "world" / "door").write_text(door)  # just before the next
            second = await client.follow(bench.goal(client, "go", x=2))
            other = await client.follow(bench.goal(client, "nudge"))
            return first.state, second.error, other.state

    first, error, other = asyncio.run(story())

    assert (first, other) == ("SUCCEEDED", "SUCCEEDED")
    assert (error.name, error.happened) == ("Rejected", "no")
    assert error.message == f"arm.go: {words}; nothing was started"
    assert len([deed for deed in bench.deeds() if deed.startswith("arm go")]) == 1


def test_an_action_of_the_safe_state_that_is_meanwhile_ends_what_runs(bench):
    actions = bench.contract()["actions"]
    actions["halt"]["meanwhile"] = True

    async def story():
        async with bench.connected(contract={"actions": actions}) as client:
            held = bench.goal(client, "hold", seconds=30)
            following = asyncio.create_task(client.follow(held))
            await bench.until(f"hold {held.id}")
            halted = await client.follow(bench.goal(client, "halt"))
            return halted.state, await asyncio.wait_for(following, 500)

    halted, outcome = asyncio.run(story())

    assert halted == "SUCCEEDED"
    assert (outcome.state, outcome.error.name) == ("CANCELED", "Stopped")
    assert outcome.error.message.startswith("arm was brought to its safe state (halt) at ")
