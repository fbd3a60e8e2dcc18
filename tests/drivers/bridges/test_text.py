"""Instruments with a line protocol of their own, said in YAML by patterns."""

import asyncio
import contextlib
import json
import os
import queue
import socket
import threading

import pytest

from labrun.drivers.bridges.checksum import Checksum
from labrun.drivers.contract_tests.pty_peer import PtyPeer
from labrun.drivers.driver import ActionFailed, GoalContext

VOLTAGE = {"send": "MEAS:VOLT:DC?", "effect": "pure", "returns": {"voltage": {"unit": "V"}}}
GO = {
    "send": "GO {to:.1f}", "params": {"to": {"unit": "mm"}}, "answer": r"OK (\d+)",
    "done": r"DONE at .* mm", "returns": {"count": {"type": "integer"}}, "timeout": "5 s",
    "errors": {"Jam": {"answer": "ERR JAMMED", "happened": "no", "summary": "free it by hand"}},
}  # fmt: skip
LOGIN = [
    {"after": "login: ", "send": "lab"},
    {"after": "password: ", "send": "secret"},
    {"after": "welcome"},
]
ERRORS = {"Unknown": {"answer": r"^\?1", "happened": "no"}}


def free_port():
    """Below those that the system gives away, and from another one for each process."""
    for port in range(20000 + os.getpid() % 8000, 32000):
        with contextlib.suppress(OSError), socket.socket(type=socket.SOCK_DGRAM) as made:
            made.bind(("", port))
            return port
    return None


OURS = free_port()


def config(where, **more):
    actions = more.pop("actions", {})
    actions = {"voltage": VOLTAGE, "go": GO, **actions}
    return {"resource": where, "actions": actions, "errors": ERRORS, **more}


@pytest.mark.parametrize(
    ("habits", "said"),
    [
        ({}, {}),
        ({"over": "udp"}, {}),
        ({"over": "udp", "to_port": OURS}, {"local_port": OURS}),
        ({"over": "pty", "end": "\r\n"}, {"terminator": "\r\n"}),
        ({"end": "\r", "unit": " mV"}, {"terminator": {"write": "\r", "read": "\r"}}),
        ({"chatter": "T=21.5 C"}, {}),
        ({"banner": "PUMP 3000 ready", "banner_s": 0.3}, {"banner": "ready"}),
        ({"echo": True, "end": "\r\n"}, {"echo": True}),
        ({"echo": True, "echo_end": "\r", "end": "\x03", "over": "pty"},
         {"echo": True, "terminator": {"write": "\r", "read": "\x03"}}),
        ({"echo": True, "checksum": True}, {"echo": True, "checksum": {"of": "xor", "after": "*"}}),
        ({"login": True}, {"login": LOGIN}),
    ],
)  # fmt: skip
def test_a_reading_and_a_move_that_takes_time(peer, once, habits, said):
    there = peer(**habits, error_query=False)
    hello = {
        "send": "*IDN?",
        "answer": "ACME,(?P<model>[^,]+).*",
        "returns": {"model": {"type": "string"}},
    }
    reading = {**VOLTAGE, "answer": r"\+?(?P<voltage>\d\.\d+E[+-]\d+ ?m?V?)"}
    said = config(there.where, **said, hello=hello, actions={"voltage": reading})

    assert once("text", said, "voltage") == {"voltage": 1.25}
    assert once("text", said, "go", to=12.5) == {"count": 1}
    assert there.done("go") == [{"done": "go", "given": "12.5"}]


def test_the_instruments_refusals_are_named_errors(peer, once):
    there = peer(error_query=False)
    said = config(there.where, actions={"x": {"send": "XYZ"}, "y": {"send": "XYZ", "answer": "OK"}})
    with pytest.raises(ActionFailed, match="answered 'ERR JAMMED': free it by hand") as jam:
        once("text", said, "go", to=200)
    with pytest.raises(ActionFailed, match=r"'\?1 unknown command'") as unknown:
        once("text", said, "x")
    with pytest.raises(ActionFailed) as answered:
        once("text", said, "y")

    assert (jam.value.name, jam.value.happened) == ("Jam", "no")
    assert (unknown.value.name, unknown.value.happened) == ("Unknown", "no")
    assert answered.value.name == "Unknown"


def test_an_answer_that_is_none_says_what_came(peer, once):
    said = {**VOLTAGE, "send": "*IDN?", "timeout": "0.3 s"}
    with pytest.raises(
        ActionFailed, match=r"answered 'ACME,DM-1,0042,1.0'.*is not a number"
    ) as odd:
        once("text", config(peer().where, actions={"voltage": said}), "voltage")
    silent = {**VOLTAGE, "send": "ABOR", "timeout": "0.3 s"}
    with pytest.raises(ActionFailed, match="was sent 'ABOR' and was silent") as nothing:
        once("text", config(peer(name="b").where, actions={"voltage": silent}), "voltage")

    assert (odd.value.name, nothing.value.name) == ("BadAnswer", "Timeout")


def test_a_login_that_is_refused_is_said(peer, once):
    wrong = [LOGIN[0], {"after": "password: ", "send": "else"}, {"after": "welcome"}]
    with pytest.raises(OSError, match=r"did not say 'welcome', but 'go away") as refused:
        once("text", config(peer(login=True).where, login=wrong, timeout=0.3), "voltage")

    assert "else" not in str(refused.value)


def test_an_answer_with_a_wrong_checksum_is_none(peer, once):
    """What the instrument has done is then not known, and is not done again."""
    there = peer(error_query=False, checksum=True, noise="~")
    said = config(there.where, checksum={"of": "xor", "after": "*"})
    with pytest.raises(ActionFailed, match="its checksum is not that of the line") as garbled:
        once("text", said, "go", to=5)

    assert (garbled.value.name, garbled.value.happened) == ("Timeout", "unknown")
    assert len(there.done("go")) == 1


@pytest.mark.parametrize(
    ("of", "form", "line"),
    [
        ("sum", "03d", "1230030902=?112"),
        ("complement", "02X", "1230030902=?90"),
        ("crc16", "04X", "123456789" + "4B37"),
        ("ccitt", "04X", "123456789" + "29B1"),
        ("xmodem", "04X", "123456789" + "31C3"),
        ("inverted", "04X", "123456789" + "FE22"),
        ({"polynomial": 0x1021, "start": 0xFFFF, "reflected": True, "final": 0xFFFF}, "04X", "123456789906E"),
        ("fletcher", "04X", "\x06\x08\0\0" + "0E30"),  # UBX-CFG-RATE
        ({"bits": 8, "polynomial": 0x31, "reflected": True}, "02x", "123456789a1"),
        ({"bits": 32, "polynomial": 0x04C11DB7, "start": 0xFFFFFFFF}, "08X", "1234567890376E6E7"),
    ],
)  # fmt: skip
def test_checksums_are_those_of_their_specifications(of, form, line):
    """Sum: as a gauge's manual has it; CRC: the check values of Greg Cook's catalogue."""
    said, size = Checksum(of=of, form=form), len(format(0, form))

    assert said.added(line[:-size].encode()) == line.encode()
    assert said.taken(line.encode()) == line[:-size].encode()
    assert said.taken(line.replace("3", "4", 1).encode()) is None


def test_a_reading_whose_datagram_is_lost_is_asked_for_once_more(peer, once):
    said = config(peer(over="udp", deaf=1).where, timeout=1)

    assert once("text", said, "voltage") == {"voltage": 1.25}


def test_another_instrument_is_known_by_its_hello(peer, once):
    hello = {"send": "*IDN?", "answer": "PUMP.*", "timeout": "0.3 s"}
    with pytest.raises(OSError, match=r"answered 'ACME.*is another device there"):
        once("text", config(peer().where, hello=hello), "voltage")


@pytest.mark.parametrize(
    ("answer", "said", "told"),
    [
        ("0001 Changer V1", {}, r"the whole has to: write `\.\*` where more may stand$"),
        ("Á", {"frame": r"\xc0.{9}"}, r"sent '\\xc3\\x81' without a whole `frame`"),
        ("Changer\r\nok", {"prompt": "ready"}, r"sent 'Changer.*ok' without its `prompt`"),
    ],
)
def test_what_does_not_fit_is_told_by_what_was_waited_for(ask, tmp_path, answer, said, told):
    hello = {"send": "id", "answer": "Changer", "timeout": "0.3 s"}

    async def say(_):
        return answer

    with PtyPeer(tmp_path / "port", say) as peer, pytest.raises(OSError, match=told):
        ask("text", config(peer.port, hello=hello, **said), None)


def test_one_that_repeats_what_it_hears_is_told_as_that(peer, once):
    hello = {"send": "*IDN?", "answer": "ACME.*", "timeout": "0.3 s"}
    with pytest.raises(OSError, match="say `echo: true`"):
        said = config(peer(echo=True, prompt="DM> ").where, hello=hello, prompt="DM> ")
        once("text", said, "voltage")


def test_one_that_speaks_by_itself_is_listened_to(peer, once):
    there = peer(chatter="T=21.5 C")
    heard = {"answer": "T=(.*)", "effect": "pure", "returns": {"t": {"unit": "K"}}}

    assert once("text", config(there.where, actions={"t": heard}), "t")["t"] == pytest.approx(
        294.65
    )


def test_what_is_watched_is_its_status(peer, ask):
    async def story(driver):
        return await driver.status()

    assert ask("text", config(peer().where, status=["voltage"]), story) == {"voltage": 1.25}


def test_the_goals_id_can_be_left_with_the_instrument(peer, ask):
    there = peer()
    said = {"send": "DISP {goal}", "effect": "once"}

    async def story(driver):
        await driver.dispense(GoalContext("run/map/1"))
        return await driver.voltage(GoalContext("run/y/1"))

    ask("text", config(there.where, actions={"dispense": said}), story)

    assert there.done("dispense") == [{"done": "dispense", "given": "run/map/1"}]


@pytest.mark.slow
@pytest.mark.posix("a pseudo-terminal")
def test_an_answer_that_comes_too_late_on_a_serial_line_is_not_that_of_the_next_question(
    ask, tmp_path
):
    late, turn = threading.Event(), asyncio.Lock()

    async def answer(line):
        async with turn:
            await asyncio.to_thread(late.wait)
            return line[:2]

    async def story(driver):
        with pytest.raises(ActionFailed, match="it was sent 'T1\\?' and was silent"):
            await driver.method("t1")(GoalContext("a"))
        asyncio.get_running_loop().call_later(0.3, late.set)
        return await driver.method("t2")(GoalContext("b"))

    says = {"returns": {"t": {"type": "string"}}, "effect": "pure"}
    actions = {"t1": {"send": "T1?", **says}, "t2": {"send": "T2?", **says}}
    with PtyPeer(tmp_path / "port", answer) as peer:
        said = {"resource": peer.port, "timeout": 2, "actions": actions}
        assert ask("text", said, story) == {"t": "T2"}


def test_json_rpc_over_a_websocket_is_asked_answered_and_asked_again_after_a_loss(ask):
    heard = []

    async def rpc(socket):
        async for message in socket:
            heard.append(json.loads(message))
            await socket.send(json.dumps({"method": "log", "params": ["unasked"]}))
            if len(heard) == 3:
                return
            await socket.send(json.dumps({"id": 1, "result": {"t": 21.5}}))

    get_t = {"send": {"id": 1, "method": "get_t"}, "effect": "once",
             "returns": {"t": {"unit": "degC", "at": "result.t"}}}  # fmt: skip
    said = {"ignore": '.*"method".*', "timeout": "5 s", "actions": {"get_t": get_t}}

    async def story(made):
        with pytest.raises(ActionFailed, match="the connection was closed"):
            for n in range(3):
                assert await made.method("get_t")(GoalContext(f"run/{n}/1")) == {"t": 21.5}
        return await made.method("get_t")(GoalContext("run/3/1"))

    with served(rpc) as port:
        again = ask("text", {**said, "resource": f"ws://127.0.0.1:{port}/api"}, story)
    with pytest.raises(OSError, match=rf"ws://127.0.0.1:{port}/api cannot be reached: nothing lis"):
        ask("text", {**said, "resource": f"ws://127.0.0.1:{port}/api"}, story)

    assert again == {"t": 21.5}
    assert heard == [{"id": 1, "method": "get_t"}] * 4


def test_a_websocket_is_reached_past_the_proxy_that_the_system_has_for_web_pages(ask, monkeypatch):
    for name in ("no_proxy", "NO_PROXY"):
        monkeypatch.delenv(name, raising=False)
    for name in ("http_proxy", "https_proxy", "all_proxy"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")

    async def say(socket):
        async for _ in socket:
            await socket.send("T 21.5")

    async def story(made):
        return await made.method("t")(GoalContext("run/1/1"))

    says = {"send": "T?", "answer": "T (.*)", "returns": {"t": {"unit": "degC"}}, "effect": "pure"}
    with served(say) as port:
        resource = f"ws://127.0.0.1:{port}/"
        assert ask("text", {"resource": resource, "actions": {"t": says}}, story) == {"t": 21.5}


@contextlib.contextmanager
def served(speak):
    """The port of a WebSocket server in a thread of its own, until the block ends."""

    async def speak_until_the_end():
        from websockets.asyncio.server import serve

        async with serve(speak, "127.0.0.1", 0) as server:
            ports.put((server.sockets[0].getsockname()[1], asyncio.get_running_loop(), over))
            await over.wait()

    ports, over = queue.Queue(), asyncio.Event()
    thread = threading.Thread(target=lambda: asyncio.run(speak_until_the_end()))
    thread.start()
    port, loop, over = ports.get()
    try:
        yield port
    finally:
        loop.call_soon_threadsafe(over.set)
        thread.join()
