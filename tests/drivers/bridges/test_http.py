"""A shaker with an HTTP interface, in a process of its own."""

import asyncio
from pathlib import Path
from urllib.parse import quote

import pytest

from labrun.drivers.bridges.http_config import HttpConfig
from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext

RPM = {"type": "number", "unit": "rpm"}
ACTIONS = {
    "speed": {"get": "/state", "returns": {"speed": {**RPM, "at": "data.speed"}}},
    "written": {"get": "/state", "returns": {"speed": RPM}},
    "second": {"get": "/state", "returns": {"x": {"type": "integer", "at": "data.list.1"}}},
    "state": {"get": "/state", "returns": {"busy": {"type": "boolean", "at": "data.busy"}}},
    "count": {"get": "/state", "returns": {"count": {"type": "integer", "at": "data.count"}}},
    "missing": {"get": "/state", "returns": {"y": {"at": "data.nothing"}}},
    "set_speed": {
        "put": "/speed", "body": {"speed": "{speed}"}, "params": {"speed": RPM}, "effect": "idempotent",
    },
    "shake": {
        "post": "/shake", "body": {"goal": "{goal}"}, "until": {"do": "state", "busy": False},
        "count": "count", "cancel": True, "timeout": "20 s",
    },
    "stop": {"post": "/stop", "effect": "idempotent"},
    "broken": {"get": "/broken"},
}  # fmt: skip
ERRORS = {"TooFast": {"code": 422, "happened": "no"}}


def config(where, **more):
    return {
        "url": where,
        "actions": ACTIONS,
        "errors": ERRORS,
        "abort": "stop",
        "poll": 0.05,
        **more,
    }


def test_json_in_and_out(peer, once):
    there = peer("http_peer.py")
    said = config(there.where)

    assert once("http", said, "set_speed", speed=300.0) == {}
    assert once("http", said, "speed") == {"speed": 300}
    assert once("http", said, "written") == {"speed": 300}
    assert once("http", said, "second") == {"x": 2}
    assert there.done("speed") == [{"done": "speed", "to": 300.0}]


def test_what_takes_time_is_waited_for_and_can_be_stopped(peer, ask):
    there = peer("http_peer.py", work_s=0.5)

    async def story(driver):
        await driver.shake(GoalContext("run/x/1"))
        goal = GoalContext("run/x/2")
        second = asyncio.ensure_future(driver.shake(goal))
        await asyncio.sleep(0.2)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled):
            await second

    ask("http", config(there.where), story)

    assert [one["done"] for one in there.done()] == ["on", "dispense", "stop"]
    assert there.done("dispense")[0]["given"] == "run/x/1"


def test_a_job_is_asked_for_by_the_number_that_it_got(peer, ask):
    """And what the device says with status 200 is a failure all the same, if the lab names it."""
    there = peer("http_peer.py")
    number = {"type": "integer"}
    start = {
        "post": "/jobs", "body": {"fails": "{fails}"}, "params": {"fails": {"default": False}},
        "returns": {"number": {**number, "at": "job.id"}}, "until": {"do": "job", "state": "done"},
    }  # fmt: skip
    job = {
        "get": "/jobs/{number}",
        "params": {"number": number},
        "returns": {"state": {"type": "string"}},
    }
    lid = {
        "Lid": {"answer": "lid is open", "happened": "no"},
        "Gone": {"answer": "NO_JOB", "happened": "no"},
    }
    said = config(there.where, errors=lid)
    said["actions"] = {**ACTIONS, "start": start, "job": job}

    async def story(driver):
        first = await driver.start(GoalContext("run/x/1"))
        with pytest.raises(ActionFailed) as gone:
            await driver.job(GoalContext("run/x/2"), number=77)
        with pytest.raises(ActionFailed) as failed:
            await driver.start(GoalContext("run/x/3"), fails=True)
        return first, gone.value.name, (failed.value.name, failed.value.happened)

    assert ask("http", said, story) == ({"number": 1}, "Gone", ("Lid", "unknown"))
    assert len(there.done("job")) == 2


def test_a_job_is_asked_for_where_its_header_says(peer, once):
    there = peer("http_peer.py")
    queue = {
        "post": "/jobs", "body": {}, "until": {"do": "ask", "state": "done"},
        "returns": {"job": {"type": "string", "header": "location: (.*)"}},
    }  # fmt: skip
    ask = {
        "get": "{job}", "params": {"job": {"type": "string"}},
        "returns": {"state": {"type": "string"}, "who": {"type": ["string", "null"]}},
    }  # fmt: skip
    lost = {**queue, "returns": {"job": {"type": "string", "header": "X-Job: (.*)"}}}
    said = {**config(there.where), "actions": {**ACTIONS, "queue": queue, "ask": ask, "lost": lost}}

    assert once("http", said, "queue") == {"job": "/moved/1"}
    assert once("http", said, "ask", job="/moved/1") == {"state": "done", "who": None}
    with pytest.raises(ActionFailed, match=r"none of its headers matches 'X-Job: .*Location: "):
        once("http", said, "lost")


def test_refusals_have_names(peer, once):
    said = config(peer("http_peer.py").where)
    with pytest.raises(
        ActionFailed, match="PUT /speed and answered with status 422: too fast"
    ) as fast:
        once("http", said, "set_speed", speed=2000.0)
    with pytest.raises(ActionFailed, match="status 500") as broken:
        once("http", said, "broken")
    with pytest.raises(ActionFailed, match=r"the answer has no data\.nothing") as missing:
        once("http", said, "missing")

    assert (fast.value.name, fast.value.happened) == ("TooFast", "no")
    assert (broken.value.name, broken.value.happened) == ("DeviceError", "unknown")
    assert missing.value.name == "BadAnswer"


def test_an_answer_that_is_no_number_has_a_name(peer, ask):
    odd = {
        '{"x": NaN}': "NotANumber", '{"x": 1e999}': "Overload", '{"x": "--"}': "NotANumber",
        '{"x": null}': "BadAnswer", '{"x": true}': "BadAnswer", '{"x": {"a": 1}}': "BadAnswer",
        "parsnips": "BadAnswer", "12.5 mL": 12500, "12.5": 12.5,
    }  # fmt: skip
    names = {f"odd_{number}": text for number, text in enumerate(odd)}
    said = config(peer("http_peer.py").where, abort=None)
    said["actions"] = {
        name: {"get": f"/odd/{quote(text)}", "returns": {"x": {"unit": "uL"}}}
        for name, text in names.items()
    }

    async def story(driver):
        told = {}
        for name, text in names.items():
            try:
                told[text] = (await getattr(driver, name)(GoalContext("run/1")))["x"]
            except ActionFailed as failure:
                told[text] = failure.name
        return told

    assert ask("http", said, story) == odd


def test_what_is_no_plain_json(peer, ask):
    """A place with a parameter in it, XML, a file, codes and tenths, a form with headers and a password."""
    odd = {"type": "string"}
    said = config(peer("http_peer.py").where, abort=None, user="ada", password="x")
    said["actions"] = {
        "nth": {
            "get": "/state", "params": {"n": {"type": "integer"}},
            "returns": {"x": {"type": "integer", "at": "data.list.{n}"}},
        },
        "xml": {
            "get": "/odd/" + quote("<r><t>21.5 C</t></r>"), "answer": "(?s).*<t>(?P<t>[^<]*)</t>.*",
            "returns": {"t": {"unit": "degC"}},
        },
        "wrapped": {
            "get": "/odd/" + quote('told({"t": [21.5]});'), "answer": r"told\((.*)\);",
            "returns": {"t": {"unit": "degC", "at": "t.0"}},
        },
        "picture": {"get": "/odd/PNG", "returns": {"picture": {"format": "path"}}},
        "state": {
            "get": "/odd/" + quote('{"mode": 1, "t": 253}'),
            "returns": {"mode": {"words": {"idle": 0, "busy": 1}}, "t": {"unit": "degC", "scale": 0.1}},
        },
        "note": {
            "post": "/note", "text": "<t>{t:.1f} {{</t>", "params": {"t": {"unit": "degC"}},
            "answer": "<t>(.*) .</t>", "returns": {"t": {"unit": "degC"}},
        },
        "enter": {
            "post": "/enter", "form": {"mode": "{mode}", "go": True},
            "headers": {"If-Match": "v{mode}", "Idempotency-Key": "{goal}"},
            "params": {"mode": {"words": {"fast": "F"}}},
            "returns": {
                "mode": {**odd, "at": "form.mode"}, "go": {**odd, "at": "form.go"}, "who": odd,
                "match": odd, "key": odd,
            },
        },
    }  # fmt: skip

    async def story(driver):
        goal = GoalContext("run/x/1")
        told = [
            await driver.nth(goal, n=1), await driver.xml(goal), await driver.wrapped(goal),
            await driver.state(goal),
            await driver.note(goal, t=37), await driver.enter(goal, mode="fast"), await driver.picture(goal),
        ]  # fmt: skip
        return told, goal.files["picture"].data

    told, picture = ask("http", said, story)

    assert told == [
        {"x": 2}, {"t": 21.5}, {"t": 21.5}, {"mode": "busy", "t": 25.3}, {"t": 37.0},
        {"mode": "F", "go": "true", "who": "Basic YWRhOng=", "match": "vF", "key": "run/x/1"},
        {"picture": "picture.bin"},
    ]  # fmt: skip
    assert picture == b"PNG"


def test_one_that_is_not_there_is_said(once):
    with pytest.raises(OSError, match=r"http://127.0.0.1:9 cannot be reached.*nothing lis"):
        once("http", config("http://127.0.0.1:9"), "speed")


def test_one_that_hangs_up_is_said(ask):
    async def story(driver):
        async with await asyncio.start_server(
            lambda _, writer: writer.close(), "127.0.0.1"
        ) as there:
            at = f"http://127.0.0.1:{there.sockets[0].getsockname()[1]}"
            driver.config = driver.config.model_copy(update={"url": at})
            with pytest.raises(OSError, match="cannot be reached: dmm was asked to GET /"):
                await driver.open()

    ask("http", config("http://127.0.0.1:9"), story, opened=False)


LOGIN = {
    "headers": {"Authorization": "Bearer {token}"},
    "login": {
        "post": "/login", "body": {"user": "lab", "password": "secret"},
        "returns": {"token": {"type": "string", "at": "data.token"}},
    },
    "actions": {"dose": {"post": "/guarded"}},
}  # fmt: skip


def test_a_token_that_has_run_out_is_fetched_anew_and_nothing_is_done_twice(peer, ask):
    there = peer("http_peer.py")

    async def story(driver):
        for number in range(5):
            await driver.dose(GoalContext(f"run/x/{number}"))

    ask("http", config(there.where, **LOGIN, errors={}, abort=None), story)

    told = [one["token"] for one in there.done("guarded")]
    assert told == ["T1", "T1", "T2", "T2", "T3"]


def test_a_login_that_is_refused_is_said_in_its_words(peer, once):
    wrong = {**LOGIN, "login": {**LOGIN["login"], "body": {"password": "no"}}}

    with pytest.raises(OSError, match=r"does not let it in.*POST /login.*wrong password"):
        once("http", config(peer("http_peer.py").where, **wrong, errors={}, abort=None), "dose")


def test_a_session_of_cookies_that_has_run_out_is_begun_anew(peer, ask):
    """And a text in a path or a question is that text, not another command."""
    there = peer("http_peer.py")
    areas = {"type": "array", "items": {"type": "number"}, "at": "peaks.*.area"}
    said = {
        "url": there.where, "login": {"post": "/cookie", "form": {"password": "secret"}}, "expired": 302,
        "actions": {"command": {
            "get": "/command/{name}?v={v:+.1f}&note={note}", "effect": "once", "returns": {"areas": areas},
            "params": {"name": {"type": "string"}, "v": {"unit": "V"}, "note": {"type": "string"}},
        }},
    }  # fmt: skip

    async def story(driver):
        do = driver.method("command")
        return [
            await do(GoalContext(f"run/x/{number}"), name=name, v=1.5, note="a&v=9 %")
            for number, name in enumerate(("A", "B", "../C?x=1"))
        ]

    assert ask("http", said, story) == [{"areas": [12.5, 0.5]}] * 3
    assert [one["to"] for one in there.done("command")] == ["A", "B", "../C?x=1"]
    assert {(one["v"], one["note"]) for one in there.done("command")} == {("+1.5", "a&v=9 %")}


def test_one_that_wants_a_digest_gets_one(peer, once):
    said = {
        "url": peer("http_peer.py").where, "user": "ada", "password": "x",
        "actions": {"t": {"get": "/digest", "returns": {"t": {"unit": "degC"}}}},
    }  # fmt: skip

    assert once("http", {**said, "digest": True}, "t") == {"t": 21.5}
    with pytest.raises(ActionFailed, match="it wants `user`, `password` and `digest: true`"):
        once("http", said, "t")


def test_one_that_has_made_its_certificate_itself_is_trusted_by_it(peer, once):
    own = str(Path(__file__).parent / "peers" / "device.pem")
    said = config(peer("http_peer.py", certificate=own).where)

    assert once("http", {**said, "verify": own}, "second") == {"x": 2}
    assert once("http", {**said, "verify": False}, "second") == {"x": 2}
    with pytest.raises(
        OSError, match=r"self-signed certificate.*`verify: device\.pem` trusts its own"
    ):
        once("http", said, "second")
    with pytest.raises(OSError, match=r"`verify: no\.pem` is no certificate"):
        once("http", {**said, "verify": "no.pem"}, "second")


def test_what_is_done_when_nobody_is_logged_in_needs_a_login():
    said = HttpConfig(url="http://a", expired="login", actions={"x": {"get": "/"}})

    assert [fault.message for fault in said.faults(said.contract("x@1"), apart=False)] == [
        "there is no `login` that would be done again"
    ]


def test_a_header_that_nothing_fills_is_told():
    put = {"put": "/", "headers": {"If-Match": "{tag}"}}
    said = HttpConfig(url="http://a", headers={"X-Key": "{key}"}, actions={"x": put})

    assert sorted(fault.message for fault in said.faults(said.contract("x@1"), apart=False)) == [
        "{key}: nothing says it; what a `login` returns may stand here",
        "{tag}: the action has no parameter 'tag'; its parameters: none",
    ]


def test_a_get_that_returns_nothing_is_no_question():
    """`/relay/0?turn=toggle` must not be sent twice."""
    made = HttpConfig(url="http://a", actions=ACTIONS).contract("x@1").actions

    assert {name: made[name].effect for name in ("state", "broken")} == {
        "state": "pure",
        "broken": "once",
    }
