"""Frames as they are on the wire, and what becomes of those that are none."""

import asyncio
import json
import re
import socket
from contextlib import asynccontextmanager

import pytest
from websockets.asyncio.client import connect

from labrun.schemas.contracts import shipped_contracts

from .served import command, serve

GLOW = {
    "op": "send_action_goal",
    "action": "/Lamp_9/glow",
    "action_type": "labrun_interfaces/action/LampGlow",
}
ANSWER_S = 500


class Talk:
    """A client without a library between."""

    def __init__(self, line):
        self.line = line

    async def say(self, frame):
        await self.line.send(frame if isinstance(frame, (str, bytes)) else json.dumps(frame))

    async def hear(self, *ops):
        async with asyncio.timeout(ANSWER_S):
            while True:
                message = json.loads(await self.line.recv())
                if not ops or message["op"] in ops:
                    return message


@asynccontextmanager
async def talking(url, **options):
    async with connect(url, max_size=None, **options) as line:
        yield Talk(line)


def exchange(endpoint, *frames, hear=1, ops=()):
    async def main():
        async with talking(endpoint.url) as talk:
            for frame in frames:
                await talk.say(frame)
            return [await talk.hear(*ops) for _ in range(hear)]

    return asyncio.run(main())


def alive(endpoint):
    call = {"op": "call_service", "id": "a", "service": "rosapi/nodes"}
    return exchange(endpoint, call) == [
        {**call, "op": "service_response", "values": {"nodes": ["/labrun"]}, "result": True}
    ]


# --- golden


def test_a_goal_from_its_first_frame_to_its_last(endpoint):
    told = exchange(
        endpoint, {**GLOW, "id": "g1", "args": {"seconds": 0.1}, "feedback": True}, hear=3
    )

    same = {"action": "/Lamp_9/glow", "id": "g1"}
    result = {
        "seconds": 0.1, "pattern": [], "extra_json": "",
        "error_name": "", "error_message": "", "error_happened": "",
    }  # fmt: skip
    assert told == [
        {"op": "action_feedback", **same, "values": {"progress": 0.0, "message": "glowing red"}},
        {"op": "action_feedback", **same, "values": {"progress": 1.0, "message": "done"}},
        {"op": "action_result", **same, "values": result, "status": 4, "result": True},
    ]


def test_without_feedback_wanted_only_the_result_is_told(endpoint):
    (told,) = exchange(endpoint, {**GLOW, "id": 7, "args": {"seconds": 0.1}})

    assert (told["op"], told["id"], told["status"], told["result"]) == ("action_result", 7, 4, True)


def test_a_failed_goal_tells_every_field_with_null_for_no_number(endpoint):
    (told,) = exchange(endpoint, {**GLOW, "id": "g", "args": {"seconds": 1, "colour": "#fff"}})

    assert told["status"] == 6 and told["result"] is True
    assert told["values"] == {
        "seconds": None, "pattern": [], "extra_json": "", "error_name": "Burnt",
        "error_message": "too bright for this bulb", "error_happened": "yes",
    }  # fmt: skip


def test_a_cancelled_goal_is_status_5_and_the_cancel_itself_is_not_answered(endpoint):
    told = exchange(
        endpoint, {**GLOW, "id": "g", "args": {"seconds": 60}},
        {"op": "cancel_action_goal", "action": "/Lamp_9/glow", "id": "g"},
    )  # fmt: skip

    assert [(m["op"], m["status"], m["result"]) for m in told] == [("action_result", 5, True)]


def test_a_refused_goal_is_result_false_with_a_sentence(endpoint):
    told = exchange(endpoint, {**GLOW, "id": "g", "args": {"seconds": -1}})

    assert told == [{
        "op": "action_result", "action": "/Lamp_9/glow", "id": "g", "status": 0, "result": False,
        "values": "Lamp__9_.glow.seconds: -1 s is outside seconds 0..600 s; a limit of the contract",
    }]  # fmt: skip


def test_a_topic_bears_the_name_that_the_client_used(endpoint):
    (told,) = exchange(endpoint, {"op": "subscribe", "id": "s", "topic": "slow/status"})

    assert told["op"] == "publish" and told["topic"] == "slow/status"
    assert set(told["msg"]) == set(shipped_contracts()["gantry@1"].status["properties"])


def test_no_id_at_all_cancels_every_goal_of_the_action(endpoint):
    told = exchange(
        endpoint, {**GLOW, "id": "g", "args": {"seconds": 60}, "feedback": True},
        {"op": "call_service", "service": "/Lamp_9/beacon/_action/cancel_goal", "args": {}},
        hear=1, ops=("service_response",),
    )  # fmt: skip

    assert told == [{
        "op": "service_response", "service": "/Lamp_9/beacon/_action/cancel_goal", "result": True,
        "values": {"return_code": 0, "goals_canceling": []},
    }]  # fmt: skip


def test_the_status_of_goals_is_a_topic_for_those_who_ask(endpoint):
    async def main():
        async with talking(endpoint.url) as talk:
            await talk.say({"op": "subscribe", "topic": "/Lamp_9/glow/_action/status"})
            await talk.hear("publish")
            await talk.say({**GLOW, "id": "g", "args": {"seconds": 60}})
            began = await talk.hear("publish")
            await talk.say({"op": "cancel_action_goal", "action": "/Lamp_9/glow", "id": "g"})
            canceling, ended = await talk.hear("publish"), await talk.hear("publish")
            return [
                message["msg"]["status_list"][-1]["status"] for message in (began, canceling, ended)
            ]

    assert asyncio.run(main()) == [2, 3, 5]


# --- pieces


def test_a_message_may_come_in_pieces_in_any_order(endpoint):
    text = json.dumps({**GLOW, "id": "g", "args": {"seconds": 0.0}})
    parts = [text[i : i + 40] for i in range(0, len(text), 40)]
    pieces = [
        {"op": "fragment", "id": "f", "data": data, "num": num, "total": len(parts)}
        for num, data in enumerate(parts)
    ]
    (told,) = exchange(endpoint, *reversed(pieces))

    assert told["id"] == "g" and told["status"] == 4


def test_a_client_that_wants_pieces_gets_them(endpoint):
    call = {
        "op": "call_service",
        "id": "c",
        "service": "rosapi/services",
        "args": {},
        "fragment_size": 200,
    }
    (first,) = exchange(endpoint, call)
    pieces = exchange(endpoint, call, hear=first["total"])
    whole = json.loads(
        "".join(piece["data"] for piece in sorted(pieces, key=lambda one: one["num"]))
    )

    assert {len(piece["data"]) for piece in pieces[:-1]} == {200}
    assert "/rosapi/services" in whole["values"]["services"]


def test_pieces_of_many_messages_together_are_bounded(endpoint):
    data = "x" * (6 * 2**20)
    told = exchange(
        endpoint, *({"op": "fragment", "id": n, "data": data, "num": 0, "total": 2} for n in range(3))
    )  # fmt: skip

    assert "message 2 is dropped" in told[0]["msg"]


# --- bad input

BAD = [
    ("{", "not JSON"),
    ("[1, 2]", "a message must be a JSON object"),
    ("3", "a message must be a JSON object"),
    (b"\xff\xfe", "a binary frame must be JSON in UTF-8"),
    ("{}", "unknown operation 'None'"),
    ({"op": "fly"}, "unknown operation 'fly'"),
    ({"op": ["x"]}, "unknown operation"),
    ({"op": "advertise", "topic": "/x", "type": "std_msgs/String"}, "is not supported here"),
    ({"op": "publish", "topic": "/gantry/status", "msg": {}}, "is not supported here"),
    ({"op": "subscribe"}, "`subscribe` needs `topic`"),
    ({"op": "subscribe", "topic": None}, "`subscribe` needs `topic`"),
    ({"op": "call_service", "service": None}, "`call_service` needs `service`"),
    ({"op": "send_action_goal", "action": None}, "`send_action_goal` needs `action`"),
    ({"op": "fragment", "id": "f", "data": None, "num": 0, "total": 2}, "`fragment` needs `data`"),
    ({"op": "subscribe", "topic": 3}, "`topic` of `subscribe` must be"),
    ({"op": "subscribe", "topic": "/gantry/statuss"}, "did you mean /gantry/status?"),
    ({"op": "subscribe", "topic": "/gantry/status", "type": "std_msgs/String"}, "not a std_msgs/String"),
    ({"op": "subscribe", "topic": "/gantry/status", "compression": "png"}, "can be none and cbor"),
    ({"op": "subscribe", "topic": "/gantry/status", "throttle_rate": "often"}, "must be milliseconds"),
    ({"op": "subscribe", "topic": "/gantry/status", "fragment_size": 1}, "the minimum is 64"),
    ({"op": "unsubscribe", "topic": "/gantry/status"}, "you do not subscribe to /gantry/status"),
    ({"op": "call_service"}, "`call_service` needs `service`"),
    ({"op": "send_action_goal", "id": "g"}, "`send_action_goal` needs `action`"),
    ({"op": "cancel_action_goal", "action": "/Lamp_9/glow", "id": "no"}, "you have no goal no under way"),
    ({"op": "set_level", "level": "loud"}, "`level` must be one of"),
    ({"op": "fragment", "id": "f", "data": "x", "num": 2, "total": 2}, "fragment 2 of 2 is invalid"),
    ({"op": "fragment", "id": "f", "data": "x", "num": 0, "total": 10**9}, "is invalid"),
    ({"op": "fragment", "num": 0}, "`fragment` needs `id`"),
    ('{"a":' * 5000 + "1" + "}" * 5000, "nested deeper"),
    ("[" * 200_000, "nested deeper"),
]  # fmt: skip


@pytest.mark.parametrize(("frame", "words"), BAD, ids=range(len(BAD)))
def test_a_bad_frame_is_answered_with_a_sentence(endpoint, frame, words):
    (told,) = exchange(endpoint, frame)

    assert told["op"] == "status" and told["level"] == "error"
    assert words in told["msg"]
    assert alive(endpoint)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ("far", "must be an object"),
        ({"seconds": 1e400}, "not a finite number"),
        ({"seconds": True}, "seconds is a boolean"),
        ({"seconds": None}, "seconds is null"),
        ({"seconds": 1, "pattern": [1, "2"]}, "pattern[1] is a string but must be a int64"),
        ({"seconds": 1, "pattern": [2**63]}, "is not an int64"),
        ({"seconds": 1, "pattern": [1] * 9}, "pattern"),
        ({"seconds": 1, "colour": "blue"}, "blue"),
        ({"seconds": 1, "extra_json": "{"}, "extra_json is not JSON"),
        ({"seconds": 1, "extra_json": {"a": 1}}, "but must be a string of JSON"),
        ({}, "needs seconds"),
    ],
)  # fmt: skip
def test_a_goal_of_wrong_types_or_out_of_range_is_refused(endpoint, args, words):
    (told,) = exchange(endpoint, {**GLOW, "id": "g", "args": args})

    assert told["op"] == "action_result" and told["result"] is False
    assert words in told["values"]


def test_nan_never_reaches_a_device(endpoint):
    frame = json.dumps({**GLOW, "id": "g"})[:-1] + ', "args": {"seconds": NaN}}'
    (told,) = exchange(endpoint, frame)

    assert told["result"] is False and "nan" in told["values"]


def test_two_clients_with_the_same_id_have_a_goal_each(endpoint):
    async def main():
        async with talking(endpoint.url) as one, talking(endpoint.url) as two:
            for talk, seconds in ((one, 0.4), (two, 0.2)):
                await talk.say({**GLOW, "id": "same", "args": {"seconds": seconds}})
            return [await talk.hear("action_result") for talk in (one, two)]

    assert [told["values"]["seconds"] for told in asyncio.run(main())] == [0.4, 0.2]


def test_one_client_with_the_same_id_twice_is_told_so(endpoint):
    told = exchange(
        endpoint, {**GLOW, "id": "same", "args": {"seconds": 0.3}},
        {**GLOW, "id": "same", "args": {"seconds": 0.3}}, hear=2,
    )  # fmt: skip

    assert told[0]["result"] is False and "same is already under way" in told[0]["values"]
    assert told[1]["status"] == 4


def test_a_uuid_that_is_none_or_known_is_refused(endpoint):
    send = {"op": "call_service", "service": "/Lamp_9/glow/_action/send_goal"}
    goal = {"goal_id": {"uuid": list(range(16))}, "goal": {"seconds": 0.3}}
    answers = exchange(
        endpoint, *({**send, "id": n, "args": {**goal, "goal_id": {"uuid": uuid}}}
        for n, uuid in enumerate([[1], "x", [0] * 16, [256] * 16])), hear=4,
    )  # fmt: skip
    two = exchange(endpoint, {**send, "args": goal}, {**send, "args": goal}, hear=2)
    refused, taken = sorted(two, key=lambda answer: answer["result"])

    assert [answer["result"] for answer in answers] == [False] * 4
    assert [one["result"] for one in (taken, refused)] == [True, False]
    assert "already exists" in refused["values"]


def test_a_busy_device_rejects_the_second_goal(endpoint):
    move = {"op": "send_action_goal", "action": "/slow/move_to"}
    told = exchange(
        endpoint,
        {**move, "id": "a", "args": {"x": 20}},
        {**move, "id": "b", "args": {"x": 0}},
        hear=2,
    )

    by_id = {message["id"]: message for message in told}
    assert by_id["b"]["result"] is False and "busy" in by_id["b"]["values"]
    assert by_id["a"]["status"] == 4


def test_what_cannot_be_cancelled_says_so_and_goes_on(endpoint):
    fire = {"op": "send_action_goal", "action": "/Lamp_9/beacon", "id": "b", "feedback": True}

    async def main():
        async with talking(endpoint.url) as talk:
            await talk.say(fire)
            await talk.hear("action_feedback")
            await talk.say({"op": "cancel_action_goal", "action": "/Lamp_9/beacon", "id": "b"})
            return await talk.hear("status")

    assert "cannot be cancelled" in asyncio.run(main())["msg"]


def test_a_hundred_megabytes_are_refused_at_their_announcement(endpoint):
    host, port = endpoint.bare.removeprefix("ws://").split(":")
    shake = (
        f"GET {endpoint.path} HTTP/1.1\r\nHost: {host}:{port}\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    with socket.create_connection((host, int(port)), timeout=ANSWER_S) as line:
        line.sendall(shake.encode())
        assert line.recv(4096).startswith(b"HTTP/1.1 101")
        line.sendall(b"\x81\xff" + (100_000_000).to_bytes(8, "big") + bytes(4) + b"x" * 1000)
        answer = line.recv(4096)

    assert answer[0] == 0x88 and int.from_bytes(answer[2:4], "big") == 1009  # a close frame
    assert alive(endpoint)


def test_a_client_that_never_reads_is_dropped_and_others_are_served(endpoint):
    async def main():
        reader, writer = await asyncio.open_connection(
            *endpoint.bare.removeprefix("ws://").split(":")
        )
        key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        host = endpoint.bare.removeprefix("ws://")
        writer.write(
            f"GET {endpoint.path} HTTP/1.1\r\nHost: {host}\r\n"
            f"Upgrade: websocket\r\nConnection: Upgrade\r\n{key}".encode()
        )
        await reader.readuntil(b"\r\n\r\n")
        call = json.dumps({"op": "call_service", "service": "rosapi/topics_and_raw_types"}).encode()
        frame = bytes([0x81, 0x80 | len(call)]) + bytes(4) + call
        writer.transport.pause_reading()
        async with asyncio.timeout(500):
            while not writer.transport.is_closing():
                writer.write(frame * 100)
                await asyncio.sleep(0.01)
        writer.close()

    asyncio.run(main())

    assert alive(endpoint)


def test_a_goal_goes_on_when_its_socket_closes(endpoint):
    stop = {"op": "call_service", "service": "/Lamp_9/glow/_action/cancel_goal"}

    async def main():
        async with talking(endpoint.url) as talk:
            await talk.say({**GLOW, "id": "g", "args": {"seconds": 60}, "feedback": True})
            begun = await talk.hear("action_feedback", "action_result")
            assert begun["op"] == "action_feedback", begun
        async with talking(endpoint.url) as talk:
            await talk.say({"op": "subscribe", "topic": "/Lamp_9/glow/_action/status"})
            told = [(await talk.hear("publish"))["msg"]["status_list"][-1]]
            # It is nobody's any more, and it is there.
            await talk.say({**stop, "args": {"goal_info": told[0]["goal_info"]}})
            while told[-1]["status"] != 5:
                told.append((await talk.hear("publish"))["msg"]["status_list"][-1])
            return [goal["status"] for goal in told]

    assert list(dict.fromkeys(asyncio.run(main()))) == [2, 3, 5]


# --- who may connect


def refused(url, **headers):
    async def main():
        with pytest.raises(Exception, match="HTTP") as fault:
            async with connect(url, additional_headers=headers or None):
                pass
        return int(re.search(r"HTTP (\d+)", str(fault.value))[1])

    return asyncio.run(main())


def test_pages_of_other_sites_and_other_names_for_us_are_refused(endpoint):
    assert refused(endpoint.url, Origin="https://evil.example") == 403
    assert refused(endpoint.url, Origin="null") == 403
    port = endpoint.bare.rpartition(":")[2]
    assert refused(endpoint.url, Host=f"rebound.example:{port}") in (400, 421)
    assert refused(endpoint.url, Host="[") in (400, 421)
    assert refused(endpoint.url, Origin="http://[") == 403


@pytest.mark.slow
def test_pages_of_this_machine_and_allowed_origins_are_let_in(endpoint, lab, tmp_path):
    async def main(url, origin):
        async with talking(url, additional_headers={"Origin": origin}) as talk:
            await talk.say({"op": "call_service", "service": "rosapi/nodes"})
            return (await talk.hear())["result"]

    served = serve(
        tmp_path, "--origin", "https://page.example", "--token", "a-quite-secret-word", lab=lab
    )
    try:
        assert refused(served.url) == 401
        assert refused(f"{served.url}/?token=a-wrong-word") == 401
        assert asyncio.run(main(f"{served.url}/?token=a-quite-secret-word", "https://page.example"))
    finally:
        assert served.end() == 0
    assert asyncio.run(main(endpoint.url, "http://localhost:5173"))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--host", "0.0.0.0"], "a token is required"),
        (["--token", "short"], "is easily guessed"),
        (["--no-token", "--token", "a-quite-secret-word"], "give one of the two"),
        (["--protocols", "nowhere"], "is not a folder"),
        (["--lab", "nowhere.yaml"], "nowhere.yaml"),
        (["--node"], "this Python has no ROS 2"),
    ],
)
def test_a_wrong_call_is_a_sentence_and_status_2(tmp_path, options, words):
    done = command(tmp_path, *options)

    assert done.returncode == 2
    assert words in done.stdout + done.stderr and "Traceback" not in done.stderr


def test_a_port_that_is_taken_is_a_sentence_and_status_4(endpoint, tmp_path):
    done = command(tmp_path, "--port", endpoint.bare.rpartition(":")[2])

    assert done.returncode == 4
    assert "cannot be used" in done.stderr and "Traceback" not in done.stderr
