"""SCPI instruments said in YAML, each a process of its own with the habits of real ones."""

import asyncio
import struct

import numpy as np
import pytest

from labrun.drivers.bridges.answers import value
from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext
from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.entry import entry_text
from labrun.engine.new.device.sources import described

VOLTAGE = {"query": "MEAS:VOLT:DC?", "returns": {"voltage": {"type": "number", "unit": "V"}}}
RANGE = {
    "write": "VOLT:RANG {range:g}",
    "params": {"range": {"unit": "V", "minimum": 0.1}},
    "effect": "idempotent",
}
SWEEP = {"write": "INIT", "wait": True, "timeout": "30 s", "cancel": True, "duration": "3 s"}
DISPENSE = {"write": "DISP {volume:.1f}", "params": {"volume": {"unit": "uL"}}}


def config(where, **more):
    actions = more.pop("actions", {})
    return {"resource": where, "actions": {"voltage": VOLTAGE, **actions}, **more}


def failure(excinfo):
    return excinfo.value.name, excinfo.value.happened


def test_a_query_is_a_number_in_the_contracts_unit(peer, once):
    where = peer().where

    assert once("scpi", config(where), "voltage") == {"voltage": 1.25}
    host, port = where.split(":")
    said = config(f"TCPIP::{host}::{port}::SOCKET")
    assert once("scpi", said, "voltage") == {"voltage": 1.25}


@pytest.mark.parametrize(
    ("habits", "said"),
    [
        ({"end": "\r\n"}, {}),
        ({"end": "\r"}, {}),
        ({"banner": "Welcome to DM-1"}, {}),
        ({"banner": "Welcome to DM-1", "banner_s": 0.5}, {"banner": "Welcome"}),
        ({"echo": True}, {"echo": True}),
        ({"prompt": "DM> "}, {"prompt": "DM>"}),
        ({"prompt": "DM> ", "banner_s": 0.5}, {"prompt": "DM>"}),
        ({"prompt": "DM> ", "echo": True, "banner": "hello", "end": "\r\n"},
         {"prompt": "DM>", "echo": True}),
        ({"prompt": "=>\r\n", "end": "\r\n"}, {"prompt": ["=>\r\n", "?>\r\n"]}),
        ({"unit": " mV"[1:]}, {}),
        ({"unit": " V"}, {}),
        ({"unit": "VDC"}, {}),
        ({"answer_s": 0.3}, {"timeout": "3 s"}),
        ({"chatter": "!TEMP 31.5"}, {"ignore": "^!", "idn": "ACME"}),
        ({"over": "udp"}, {}),
        ({"over": "pty"}, {}),
        ({"over": "pty", "echo": True, "end": "\r\n", "prompt": ">"}, {"echo": True, "prompt": ">"}),
        ({"error_query": False}, {"error_query": False}),
    ],
)  # fmt: skip
def test_its_habits_can_be_said(peer, once, habits, said):
    there = peer(**habits)
    actions = {"set_range": RANGE}

    assert once("scpi", config(there.where, **said), "voltage") == {"voltage": 1.25}
    assert once("scpi", config(there.where, actions=actions, **said), "set_range", range=2.5) == {}
    assert there.soon("range") == [{"done": "range", "to": 2.5}]


def test_lines_that_nobody_asked_for_are_no_answer_of_the_drivers_own_questions(peer, once):
    there = peer(chatter="!TEMP 31.5", work_s=0.4)
    dispense = {"write": "DISP {volume:.1f}", "wait": True, "params": {"volume": {"unit": "uL"}}}
    said = config(there.where, actions={"dispense": dispense}, decimal=",", idn="ACME")

    assert once("scpi", said, "dispense", volume=2.5) == {}
    assert there.done("dispense") == [{"done": "dispense", "given": "2,5"}]


def test_another_instrument_at_its_address_is_named(peer, once):
    with pytest.raises(OSError, match=r"is 'ACME,DM-1,0042,1.0', but the lab expects 'KEITHLEY'"):
        once("scpi", config(peer().where, idn="KEITHLEY"), "voltage")


def test_one_that_is_not_there_or_silent_is_named(peer, once):
    with pytest.raises(OSError, match=r"127.0.0.1:9 cannot be reached: nothing listens there"):
        once("scpi", config("127.0.0.1:9"), "voltage")
    there = peer(answer_s=30)
    with pytest.raises(OSError, match=r"was sent '\*IDN\?' and was silent"):
        once("scpi", config(there.where, timeout="0.3 s"), "voltage")


def test_the_error_queue_becomes_named_errors(peer, once):
    where = peer().where
    errors = {"OutOfRange": {"code": -222, "happened": "no"}}
    set_range = {**RANGE, "params": {"range": {"unit": "V"}}}
    with pytest.raises(ActionFailed, match="-222 Data out of range") as named:
        once("scpi", config(where, errors=errors, actions={"r": set_range}), "r", range=5000)
    with pytest.raises(ActionFailed, match="-222") as unnamed:
        once("scpi", config(where, actions={"r": set_range}), "r", range=5000)
    with pytest.raises(ActionFailed, match=r"reports -222$") as bare:
        own = config(where, errors=errors, actions={"r": set_range}, error_query="EER?")
        once("scpi", own, "r", range=5000)
    with pytest.raises(ActionFailed, match="-113 Undefined header") as unknown:
        once("scpi", config(where, actions={"x": {"write": "XYZ 1"}}), "x")
    with pytest.raises(ActionFailed, match="-113 Undefined header") as silent:
        said = {"query": "XYZ?", "returns": {"x": {}}, "timeout": "0.3 s"}
        once("scpi", config(where, actions={"x": said}), "x")

    with pytest.raises(ActionFailed, match="unknown command") as heard:
        own = {"Refused": {"answer": "unknown command", "happened": "no"}}
        said = {"errors": own, "error_query": False, "actions": {"x": {"write": "XYZ 1"}}}
        once("scpi", config(peer(name="other", error_query=False).where, **said), "x")

    assert failure(heard) == ("Refused", "no")
    assert failure(named) == failure(bare) == ("OutOfRange", "no")
    assert failure(unnamed) == ("ExecutionError", "no")
    assert failure(unknown) == ("CommandError", "no")
    assert failure(silent) == ("CommandError", "no")


def test_of_two_commands_one_may_have_been_done(peer, once):
    there = peer()
    said = {"write": ["DISP 1", "XYZ"]}
    with pytest.raises(ActionFailed) as fault:
        once("scpi", config(there.where, actions={"x": said}), "x")

    assert failure(fault) == ("CommandError", "unknown")
    assert len(there.done("dispense")) == 1


def test_overload_and_no_number_are_errors_or_null(peer, once):
    where = peer().where
    over = {"query": "OVER?", "returns": {"x": {"unit": "V"}}}
    nan = {"query": "NAN?", "returns": {"x": {"unit": "V"}}}
    null = {"query": "OVER?", "returns": {"x": {"type": ["number", "null"], "unit": "V"}}}
    actions = {"over": over, "nan": nan, "null": null}
    with pytest.raises(ActionFailed) as first:
        once("scpi", config(where, actions=actions), "over")
    with pytest.raises(ActionFailed) as second:
        once("scpi", config(where, actions=actions), "nan")

    assert (first.value.name, second.value.name) == ("Overload", "NotANumber")
    assert once("scpi", config(where, actions=actions), "null") == {"x": None}


def test_lists_pairs_and_binary_blocks(peer, once):
    where = peer().where
    numbers = {"type": "array", "items": {"type": "number"}}
    actions = {
        "list": {"query": "LIST?", "returns": {"trace": numbers}},
        "pair": {"query": "PAIR?", "returns": {"x": {"unit": "V"}, "on": {"type": "boolean"}}},
        "curve": {"query": "CURV?", "returns": {"trace": numbers}, "block": ">f4"},
        "bytes": {"query": "CURV?", "returns": {"trace": numbers}, "block": "u1"},
    }
    said = config(where, actions=actions)

    assert once("scpi", said, "list") == {"trace": [1.0, 2.5, -3.0]}
    assert once("scpi", said, "pair") == {"x": 0.5, "on": True}
    second = struct.unpack(">f", bytes([0x0A, 0x0D, 0, 0x23]))[0]
    assert once("scpi", said, "curve")["trace"] == pytest.approx([1.0, second])
    assert once("scpi", said, "bytes")["trace"] == [63, 128, 0, 0, 10, 13, 0, 35]


def test_a_picture_travels_as_a_file(peer, ask):
    picture = {
        "query": "CURV?", "block": "file", "params": {"file": {"format": "path"}},
        "returns": {"file": {"format": "path"}},
    }  # fmt: skip

    async def story(driver):
        goal = GoalContext("run/x/1")
        return await driver.picture(goal, file="a/screen.bin"), goal.files

    result, files = ask("scpi", config(peer().where, actions={"picture": picture}), story)

    assert result == {"file": "a/screen.bin"}
    assert files["file"].data == bytes([63, 128, 0, 0, 10, 13, 0, 35])


def test_a_long_action_ends_when_it_is_aborted(peer, ask):
    there = peer(work_s=20)

    async def story(driver):
        goal = GoalContext("run/x/1")
        sweep = asyncio.ensure_future(driver.sweep(goal))
        await asyncio.to_thread(there.soon, "init")
        goal.cancelled.set()
        with pytest.raises(ActionCanceled):
            await sweep
        return await driver.voltage(GoalContext("run/y/1"))

    said = config(there.where, abort="ABOR", actions={"sweep": SWEEP})

    assert ask("scpi", said, story) == {"voltage": 1.25}
    assert [one["done"] for one in there.done()][1:] == ["init", "abort"]


def test_a_broken_line_costs_a_reading_nothing_and_a_command_is_not_repeated(peer, ask):
    there = peer(closes=True)

    async def closed(driver):
        while driver.lines.is_open:  # noqa: ASYNC110 - it tells nobody that it was closed
            await asyncio.sleep(0.02)

    async def story(driver):
        first = await driver.voltage(GoalContext("run/x/1"))
        await closed(driver)
        await driver.dispense(GoalContext("run/y/1"), volume=3)
        await closed(driver)
        return first, await driver.voltage(GoalContext("run/x/2"))

    said = config(there.where, actions={"dispense": DISPENSE})

    assert ask("scpi", said, story) == ({"voltage": 1.25}, {"voltage": 1.25})
    assert there.done("dispense") == [{"done": "dispense", "given": "3.0"}]


def test_a_late_answer_is_not_taken_for_the_next(peer, ask):
    there = peer(answer_s=0.5)
    slow = {"query": "VOLT:RANG?", "returns": {"range": {"unit": "V"}}, "timeout": "0.2 s"}

    async def story(driver):
        with pytest.raises(ActionFailed) as fault:
            await driver.get_range(GoalContext("run/x/1"))
        return fault.value.name, await driver.voltage(GoalContext("run/x/2"))

    said = config(there.where, actions={"get_range": slow}, timeout="3 s")

    assert ask("scpi", said, story) == ("Timeout", {"voltage": 1.25})


def test_a_text_with_a_line_end_is_no_second_command(peer, once):
    there = peer()
    label = {"write": "OUTP {text}", "params": {"text": {"type": "string"}}}
    with pytest.raises(ActionFailed, match="control characters; nothing was sent"):
        once("scpi", config(there.where, actions={"x": label}), "x", text="ON\nDISP 5")

    assert there.done("dispense") == []


def test_the_record_names_the_last_once_action(peer, ask):
    there = peer()

    async def story(driver):
        before = await driver.last_once(GoalContext("p"))
        await driver.dispense(GoalContext("run/y/1"), volume=3)
        return before, await driver.last_once(GoalContext("p"))

    said = config(there.where, actions={"dispense": DISPENSE})

    assert ask("scpi", said, story) == ({"goal_id": None}, {"goal_id": "run/y/1"})


@pytest.mark.parametrize(("counts", "answer"), [(True, "run/y/1"), (False, None)])
def test_what_was_cut_off_is_known_by_a_count_or_not_at_all(peer, ask, counts, answer):
    there = peer(work_s=1.0)
    count = {"query": "COUN?", "returns": {"count": {"type": "integer"}}}
    dispense = {**DISPENSE, "timeout": "3 s", **({"count": "count"} if counts else {})}
    said = config(there.where, actions={"dispense": dispense, "count": count})

    async def cut(driver):
        doing = asyncio.ensure_future(driver.dispense(GoalContext("run/y/1"), volume=3))
        await asyncio.sleep(0.4)
        await driver.drop()
        doing.cancel()
        await asyncio.gather(doing, return_exceptions=True)

    async def probe(driver):
        return await driver.last_once(GoalContext("p"))

    ask("scpi", said, cut)

    assert ask("scpi", said, probe) == {"goal_id": answer}


def test_a_pulse_does_not_go_out_when_its_range_is_refused(peer, once):
    """And what is refused after something was sent may have happened."""
    there = peer()
    pulse = {"write": ["VOLT:RANG {range:g}", "DISP {range:g}"], "params": {"range": {"unit": "V"}}}
    then = {
        "write": ["DISP 1", "VOLT:RANG 5000"],
        "errors": {"TooHigh": {"code": -222, "happened": "no"}},
    }
    said = config(there.where, actions={"pulse": pulse, "then": then})
    with pytest.raises(ActionFailed) as refused:
        once("scpi", said, "pulse", range=5000.0)
    assert there.done("dispense") == []
    with pytest.raises(ActionFailed) as late:
        once("scpi", said, "then")

    assert (refused.value.name, refused.value.happened) == ("ExecutionError", "no")
    assert (late.value.name, late.value.happened) == ("TooHigh", "unknown")
    assert len(there.done("dispense")) == 1


def test_a_comma_within_quotes_is_part_of_a_text(peer, once):
    words = {"x": {"type": "number"}, "words": {"type": "string"}, "n": {"type": "integer"}}
    said = config(peer().where, actions={"words": {"query": "WORDS?", "returns": words}})

    assert once("scpi", said, "words") == {"x": 1.5, "words": "none, or so", "n": 2}


def test_nothing_is_sent_when_the_count_before_it_is_silent(peer, once):
    there = peer(error_query=False)
    dispense = {"write": "DISP 1", "count": "silent"}
    silent = {"query": "ABOR?", "returns": {"n": {"type": "integer"}}, "timeout": 0.3}
    said = config(there.where, actions={"silent": silent, "dispense": dispense}, error_query=False)
    with pytest.raises(ActionFailed, match="nothing was sent") as failed:
        once("scpi", said, "dispense")

    assert (failed.value.name, failed.value.happened) == ("Lost", "no")
    assert there.done("dispense") == []


@pytest.mark.parametrize("knows", [True, False])
def test_a_lab_entry_is_written_from_what_the_instrument_says_of_itself(peer, tmp_path, knows):
    known = described(f"visa:{peer(help=knows).where}")
    (tmp_path / "lab.yaml").write_text(f"devices:\n{entry_text('dmm', known)}", "utf-8")
    lab, problems = load_lab(tmp_path / "lab.yaml")
    effects = {name: one.effect for name, one in lab.contracts["dmm@1"].actions.items()}
    said = {
        "abort": "once", "read_measure_voltage_dc": "pure", "read_voltage_range": "pure",
        "set_voltage_range": "idempotent",
    }  # fmt: skip

    assert problems == []
    assert lab.lab.devices["dmm"].config["idn"] == "DM-1"
    assert effects == {
        "identity": "pure",
        "reset": "once",
        "last_once": "pure",
        **(said if knows else {}),
    }


@pytest.mark.parametrize("kind", ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f2", "f4", "f8"])
@pytest.mark.parametrize("order", ["<", ">"])
def test_a_block_is_read_as_numpy_reads_it(kind, order):
    data = bytes(range(16))
    items = {"type": "number" if kind[0] == "f" else "integer"}
    said = {"type": "array", "items": items, "bytes": f"{order}{kind}"}
    read = value(data.decode("latin-1"), said)

    assert np.array(read, f"{order}{kind}").tobytes() == data
