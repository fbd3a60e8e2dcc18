"""A furnace by Modbus: pymodbus serves it in a process of its own."""

import asyncio

import pytest

from labrun.drivers.bridges.modbus_config import Register
from labrun.drivers.driver import ActionFailed, GoalContext

DEGREES = {"type": "number", "unit": "degC"}
REGISTERS = {
    "temperature": {"input": 0, "type": "int16", "scale": 0.1},
    "doses": {"input": 1},
    "busy": {"input": 2},
    "broken": {"input": 4, "type": "float32"},
    "turned": {"input": 6, "type": "float32"},
    "word": {"input": 8, "type": "string", "length": 2},
    "third": {"input": 6, "bit": 3},
    "seventh": {"input": 7, "bit": 14},
    "target": {"holding": 10, "type": "int16", "scale": 0.1},
    "gain": {"holding": 20, "type": "float32"},
    "portion": {"holding": 22, "type": "bcd16"},
    "tens": {"holding": 22, "bits": [4, 7]},
    "letters": {"input": 8, "type": "bcd16"},
    "nowhere": {"holding": 40001},
    "other": {"input": 0, "unit": 2},
    "start": {"coil": 0},
    "door": {"discrete": 0},
}
ACTIONS = {
    "temperature": {"read": "temperature", "returns": {"temperature": DEGREES}},
    "door": {"read": "door", "returns": {"door": {"type": "boolean"}}},
    "doses": {"read": ["doses"], "returns": {"doses": {"type": "integer"}}},
    "state": {"read": ["busy"], "returns": {"busy": {"type": "boolean"}}},
    "broken": {"read": ["broken"], "returns": {"broken": {}}},
    "said": {"read": ["busy"], "returns": {"busy": {"words": {"idle": 0, "dosing": 1}}}},
    "other": {"read": ["other"], "returns": {"other": {}}, "timeout": "0.3 s"},
    "heat": {"write": {"target": "{to}"}, "params": {"to": DEGREES}, "effect": "idempotent"},
    "set_gain": {
        "write": {"gain": "{gain}"}, "read": "gain", "params": {"gain": {"type": "number"}},
        "returns": {"gain": {"type": "number"}}, "effect": "idempotent",
    },
    "set_portion": {
        "write": {"portion": "{n}"}, "read": ["portion", "tens"], "params": {"n": {"type": "integer"}},
        "returns": {"portion": {"type": "integer"}, "tens": {"type": "integer"}},
    },
    "letters": {"read": "letters", "returns": {"letters": {"type": "integer"}}},
    "lost": {"read": "nowhere", "returns": {"nowhere": {}}},
    "dose": {
        "write": {"start": True}, "until": {"do": "state", "busy": False}, "count": "doses",
        "timeout": "6 s",
    },
}  # fmt: skip


def config(where, **more):
    return {"resource": where, "registers": REGISTERS, "actions": ACTIONS, "poll": 0.05, **more}


def test_registers_have_types_scales_and_units(peer, once):
    there = peer("modbus_peer.py")
    said = config(there.where)

    assert once("modbus", said, "temperature") == {"temperature": 215.3}
    assert once("modbus", said, "door") == {"door": True}
    assert once("modbus", said, "said") == {"busy": "idle"}
    with pytest.raises(ActionFailed, match=r"read input registers 0 \(other\)"):
        once("modbus", said, "other")  # a device of its own on the line, which is not there
    assert once("modbus", said, "set_gain", gain=-25.3) == {"gain": -25.3}
    assert once("modbus", said, "set_portion", n=1234) == {"portion": 1234, "tens": 3}
    for action, given, words in (
        ("set_portion", {"n": 12345}, "12345 does not fit into bcd16"),
        ("letters", {}, "letters: 4f 56 is no >bcd2: each of its digits is 0 to 9"),
    ):
        with pytest.raises(ActionFailed, match=words):
            once("modbus", said, action, **given)
    once("modbus", said, "heat", to=123.4)
    assert there.done("write")[-1] == {"done": "write", "address": 10, "values": [1234]}
    once("modbus", said, "heat", to=-1)
    assert there.done("write")[-1]["values"] == [65526]


def test_a_dose_is_waited_for_and_counted(peer, ask):
    there = peer("modbus_peer.py", work_s=0.4)

    async def story(driver):
        await driver.dose(GoalContext("run/x/1"))
        return (await driver.doses(GoalContext("c")), await driver.last_once(GoalContext("p")))

    told = ask("modbus", config(there.where), story)

    assert told == ({"doses": 1}, {"goal_id": "run/x/1"})
    assert len(there.done("dispense")) == 1


def test_words_and_bytes_may_be_turned_round_but_not_a_text(peer, once):
    upright = {"upright": {"input": 4, "type": "uint32", "word_order": "big"}}
    names = ["upright", "turned", "word", "third", "seventh"]
    kinds = [{"type": kind} for kind in ("integer", "number", "string", "boolean", "boolean")]
    said = config(peer("modbus_peer.py").where, word_order="little", byte_order="little")
    said["registers"] = {**REGISTERS, **upright}
    both = {"read": names, "returns": dict(zip(names, kinds, strict=True))}
    plain = {**said, "byte_order": "big", "actions": {"word": {**both, "read": "word"}}}
    plain["actions"]["word"]["returns"] = {"word": {"type": "string"}}
    own = {**plain, "registers": {"word": {**REGISTERS["word"], "byte_order": "little"}}}

    told = once("modbus", {**said, "actions": {"both": both}}, "both")

    assert told.pop("upright") == 0xC07F0000
    assert told == {"turned": 1.5, "word": "VONE", "third": False, "seventh": True}
    assert once("modbus", plain, "word") == {"word": "OVEN"}
    assert once("modbus", own, "word") == {"word": "VONE"}


def test_a_device_that_refuses_questions_while_it_works_is_not_asked_to_work_again(peer, ask):
    """Busy for a while, and then a question that it does not know: both say nothing of the dose."""
    there = peer("modbus_peer.py", work_s=0.4, rude=True)
    wrong = {"lost": {"read": "nowhere", "returns": {"nowhere": {"type": "integer"}}}}
    until = {"dose_b": {**ACTIONS["dose"], "until": {"do": "lost", "nowhere": 1}}}
    then = {"dose_c": {"write": {"start": True}, "read": "nowhere", "count": "doses"}}
    said = config(there.where)
    said["actions"] = {**ACTIONS, **wrong, **until, **then}

    async def story(driver):
        await driver.dose(GoalContext("run/x/1"))
        fates = []
        for action in (driver.dose_b, driver.dose_c):
            with pytest.raises(ActionFailed) as failed:
                await action(GoalContext("run/x/2"))
            fates.append((failed.value.name, failed.value.happened))
            await asyncio.sleep(1)
        return fates

    assert ask("modbus", said, story) == [("IllegalAddress", "unknown")] * 2
    assert len(there.done("dispense")) == 3


def test_one_that_writes_only_several_registers_is_written_so(peer, once):
    there = peer("modbus_peer.py", several=True)
    once("modbus", config(there.where), "heat", to=100.0)

    assert [one["values"] for one in there.done("write")] == [[1000]]


def test_refusals_have_names(peer, once):
    said = config(peer("modbus_peer.py").where)
    with pytest.raises(
        ActionFailed, match=r"registers 40001 \(nowhere\).*exception 2.*a manual is \{holding: 0\}"
    ) as lost:
        once("modbus", said, "lost")
    with pytest.raises(ActionFailed, match="broken: it answered 'nan': it has no number") as nan:
        once("modbus", said, "broken")
    with pytest.raises(OSError, match="there is no port /dev/ttyNone: is the cable plugged in"):
        once("modbus", config("/dev/ttyNone"), "lost")
    with pytest.raises(ActionFailed, match="does not fit into int16") as large:
        once("modbus", said, "heat", to=5000)

    assert (lost.value.name, lost.value.happened) == ("IllegalAddress", "no")
    assert nan.value.name == "NotANumber"
    assert (large.value.name, large.value.happened) == ("IllegalValue", "no")


def test_a_raw_value_may_stand_for_none(peer, once):
    where = peer("modbus_peer.py").where
    registers = {"probe": {"input": 1, "nothing": [0]}}
    returns = {"probe": {"type": ["integer", "null"]}}
    actions = {
        "sure": {"read": "probe", "returns": {"probe": {"type": "integer"}}},
        "may_lack": {"read": "probe", "returns": returns},
    }
    said = {"resource": where, "registers": registers, "actions": actions}

    assert once("modbus", said, "may_lack") == {"probe": None}
    with pytest.raises(ActionFailed, match="probe: it answered 0, which is no value") as none:
        once("modbus", said, "sure")
    assert none.value.name == "NotANumber"


def test_a_connection_that_is_cut_is_not_waited_for(ask):
    async def cut(reader, writer):
        await reader.read(12)
        writer.write(b"half")
        writer.close()

    async def story(driver):
        async with await asyncio.start_server(cut, "127.0.0.1", 0) as server:
            port = server.sockets[0].getsockname()[1]
            at = {"resource": f"127.0.0.1:{port}"}
            driver.config = driver.config.model_copy(update=at)
            await driver.open()
            with pytest.raises(ActionFailed, match="the connection was closed") as lost:
                await driver.dose(GoalContext("run/x/1"))
        return lost.value.name, lost.value.happened

    said = config("127.0.0.1:9", timeout="1 h")
    said["actions"]["dose"] = {"write": {"start": True}}

    assert ask("modbus", said, story, opened=False) == ("Lost", "unknown")


def test_one_that_is_not_there_is_said(once):
    with pytest.raises(OSError, match=r"dmm at 127\.0\.0\.1:9 cannot be reached"):
        once("modbus", config("127.0.0.1:9"), "temperature")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"temperature": {"read": "temprature"}}, "there is no register temprature"),
        ({"heat": {"write": {"temperature": 1}}}, "temperature is in the table of input registers"),
        ({"heat": {"write": {"target": "{two}"}}}, "the action has no parameter 'two'"),
        (
            {"dose": {"write": {"start": 1}, "until": {"do": "state", "bsy": 0}}},
            "state returns no bsy",
        ),
        (
            {"dose": {"write": {"start": 1}, "until": {"do": "state", "busy": "{two}"}}},
            "{two}: the action has no parameter and no result 'two'; it has none",
        ),
        ({"dose": {"write": {"start": 1}, "until": {"busy": 0}}}, "say which action is asked"),
        (
            {"dose": {"write": {"start": 1}, "until": {"do": "state", "busy": 0, "within": "0.1"}}},
            "'0.1' is not how far it may be off: a number above 0",
        ),
        ({"x": {"read": "busy", "returns": {"busi": {}}}}, "x returns busi, which is not read"),
        ({"x": {}}, "it needs `read:"),
        ({"x": {"write": {"tens": 1}}}, "tens is a bit of a holding register: write the whole"),
    ],
)
def test_what_does_not_fit_is_said(once, change, words):
    said = {**config("127.0.0.1:9"), "actions": {**ACTIONS, **change}}
    with pytest.raises(ValueError, match=words):
        once("modbus", said, "temperature")


@pytest.mark.parametrize("number", [40001, "40001", {"holding": 400001}, {"input": "40001"}])
def test_a_register_by_its_number_in_a_manual_is_told_its_address(number):
    with pytest.raises(ValueError, match=r"0001 of a manual is \{holding: 0\} here"):
        Register.model_validate(number)
