"""Instruments whose habits no standard has, said in YAML: handshakes, frames, prompts, tables, bits."""

import asyncio
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from labrun.drivers.bridges.answers import values
from labrun.drivers.bridges.lines import Lines
from labrun.drivers.bridges.template import fill
from labrun.drivers.bridges.text import Text, TextConfig
from labrun.drivers.driver import ActionFailed, GoalContext, Place

GAUGE = r"""
terminator: "\r\n"
errors: {Refused: {answer: "^\x15", happened: no}}
actions:
  pressure:
    {send: [PR1, {after: "\x06", send: "\x05"}], answer: '0,(.*)', returns: {p: {unit: mbar}}, effect: pure}
  threshold: {send: "SP1,{to:.2E}", answer: "\x06", params: {to: {unit: mbar}}, effect: idempotent}
  wrong: {send: [XX, {after: "\x06", send: "\x05"}], answer: '0,(.*)'}
"""
CONTROLLER = r"""
terminator: ""
frame: "\x06|\x15|\x02[^\x03]*\x03(?s:.)"
errors: {Refused: {answer: "\x15", happened: no}}
actions:
  temperature: {send: "\x04PV\x05", answer: '\x02PV(.*)\x03(?s:.)', returns: {t: {unit: degC}}, effect: pure}
  setting: {send: "\x04SP\x05", answer: '\x02SP(.*)\x03(?s:.)', returns: {t: {unit: degC}}, effect: pure}
"""
SUMMED = r"""
terminator: ""
frame: "\x06|\x15|\x02[^\x03]*\x03(?s:.)"
checksum: {of: xor, form: c, skips: 1, answers: false}
errors: {Refused: {answer: "\x15", happened: no}}
actions:
  heat: {send: "\x02SP{to:05.1f}\x03", answer: "\x06", params: {to: {unit: degC}}, effect: idempotent}
"""
PUMP = r"""
terminator: {write: "\r"}
prompt: [":", ">", "T*"]
errors: {Stalled: {answer: '^T\*$', happened: unknown}, Unknown: {answer: Unknown, happened: no}}
actions:
  run: {send: run, effect: idempotent}
  halt: {send: stop, effect: idempotent}
  block: {send: block, effect: idempotent}
  state: {send: "", returns: {state: {words: {idle: ":", running: ">"}}}, effect: pure}
  rate: {send: rate, returns: {rate: {unit: ml/min}}, effect: pure}
  diagnosis:
    {send: diag, answer: 'volume (?P<volume>.*)\ntime (?P<time>.*)', effect: pure,
     returns: {volume: {unit: ul}, time: {unit: min}}}
"""
STATION = r"""
ignore: "^!"
actions:
  weather:
    {send: ALL, lines: ^END, answer: 'TEMP (.*)\nHUM (.*)\nWIND (.*)', effect: pure,
     returns: {t: {unit: degC}, humidity: {unit: "%"}, wind: {unit: m/s}}}
  log: {send: LOG, lines: ^END, returns: {time: {type: array}, t: {type: array}}, effect: pure}
  first: {send: LOG, lines: 2, returns: {all: {type: array}}, effect: pure}
"""
CHILLER = r"""
terminator: {write: "\r", silence: 50 ms}
error_query: {send: ER, answer: E00}
errors: {TooHot: {answer: E07, happened: no}}
actions:
  target: {send: RT, returns: {target: {unit: degC, scale: 0.1}}, effect: pure}
  set_target: {send: "WT{to:04d}", params: {to: {unit: degC, scale: 0.1}}, effect: idempotent}
  state: {send: ST, returns: {pumping: {bit: 5, base: 16}, hot: {bit: 0, base: 16}}, effect: pure}
  code: {send: ST, returns: {code: {type: integer, base: 16}}, effect: pure}
  mode: {send: MO, returns: {mode: {words: {slow: F1, fast: F2}}}, effect: pure}
  set_mode: {send: "SM{mode}", params: {mode: {words: {slow: F1, fast: F2}}}, effect: idempotent}
"""
SPECTROMETER = r"""
actions:
  spectrum:
    {send: "SPEC?", lines: '^\.$', returns: {wavelength: {type: array}, counts: {type: array}}, effect: pure}
  raw: {send: "RAW?", block: 4<u2, returns: {counts: {type: array}}, effect: pure}
"""
POTENTIOSTAT = r"""
ignore: '^(e|M\d+)$'
actions:
  sweep:
    send: "e\nmeas_loop_lsv p c {begin:.0f}m {end:.0f}m 10m 100m\nendloop\n"
    params: {begin: {unit: mV}, end: {unit: mV}}
    answer: 'Pda(?P<e>.{7})m;ba(?P<i>.{7})(?P<prefix>.)'
    lines: '^\*'
    returns:
      e: {type: array, base: 16, offset: -134217728}
      i: {type: array, base: 16, offset: -134217728}
      prefix: {type: array, words: {1.0e-6: u, 1.0e-9: n}}
  column: {send: "e\n", lines: '^\*', answer: 'Pda(.{7}).*', returns: {e: {type: array, base: 16}}}
"""
KEYED = r"""
terminator: "\r"
hello: {send: HELLO, answer: "KEY (?P<key>.*)", returns: {key: {type: string}}}
errors: {BadKey: {answer: ERR KEY, happened: no}, Refused: {answer: ^ERR, happened: no}}
actions:
  temperature: {send: "{key};T?", returns: {t: {unit: degC}}, effect: pure}
  trace: {send: "{key};TRACE?", block: "<u4:<f4", returns: {u: {type: array}}, effect: pure}
  dose: {send: "{key};DOSE", answer: OK}
  wrong: {send: "{key};WHAT?", block: "<u4:<f4", returns: {u: {type: array}}}
"""


def said_in(text):
    return YAML(typ="safe", pure=True).load(text)


BUS = said_in((Path(__file__).parent / "bus_instruments.yaml").read_text("utf-8"))


REFUSED = {
    "gauge": ("wrong", {}, "Refused", "no"),
    "controller": ("heat", {"to": 999}, "Refused", "no"),
    "pump": ("block", {}, "Stalled", "unknown"),
    "chiller": ("set_target", {"to": 99}, "TooHot", "no"),
    "keyed": ("wrong", {}, "Refused", "no"),
    "stepper": ("go", {"x": 1000}, "WrongValue", "no"),
    "gauges": ("wrong", {}, "Unknown", "no"),
    "plc": ("wrong", {}, "NoArea", "no"),
    "ionpump": ("wrong", {}, "NoWindow", "no"),
    "manometer": ("wrong", {}, "Refused", "no"),
    "syringe": ("go", {"to": 2000}, "BadOperand", "no"),
    "flow": ("set", {"to": 200}, "OutOfRange", "no"),
    "sketch": ("heat", {"to": 99}, "TooHot", "no"),
    "service": ("wrong", {}, "Unknown", "no"),
    "acquisition": ("output", {"u": 99}, "Rejected", "no"),
    "controller485": ("wrong", {}, "Refused", "no"),
    "peristaltic": ("wrong", {}, "Refused", "no"),
    "dosing": ("dose", {"volume": 900}, "TooMuch", "no"),
    "thermostat": ("heat", {"to": 300}, "Range", "no"),
    "mixer": ("block", {}, "Timeout", "unknown"),
    "vessel": ("wrong", {}, "Refused", "no"),
    "weather": ("any", {"channel": 999}, "NoChannel", "no"),
}


@pytest.mark.parametrize(
    ("kind", "said", "told", "done"),
    [
        ("gauge", GAUGE, [
            ("pressure", {}, {"p": 0.00123}),
            ("threshold", {"to": 0.5}, {}),
        ], [{"done": "set", "to": "5.00E-01"}]),
        ("controller", CONTROLLER, [
            ("temperature", {}, {"t": 21.4}),
            ("setting", {}, {"t": 20.0}),
        ], []),
        ("controller", SUMMED, [("heat", {"to": 85.5}, {})], [{"done": "set", "to": 85.5}]),
        ("pump", PUMP, [
            ("state", {}, {"state": "idle"}),
            ("run", {}, {}),
            ("state", {}, {"state": "running"}),
            ("rate", {}, {"rate": 0.5}),
            ("diagnosis", {}, {"volume": 1250, "time": 1.5}),
        ], [{"done": "run"}]),
        ("station", STATION, [
            ("weather", {}, {"t": 21.5, "humidity": 40, "wind": 3.5}),
            ("log", {}, {"time": [0, 60, 120], "t": [21.5, 21.6, 21.9]}),
            ("first", {}, {"all": [0, 21.5, 60, 21.6]}),
        ], []),
        ("chiller", CHILLER, [
            ("target", {}, {"target": 20}),
            ("set_target", {"to": 25.3}, {}),
            ("target", {}, {"target": 25.3}),
            ("state", {}, {"pumping": True, "hot": False}),
            ("code", {}, {"code": 42}),
            ("mode", {}, {"mode": "fast"}),
            ("set_mode", {"mode": "slow"}, {}),
        ], [{"done": "target", "to": 253}, {"done": "mode", "to": "F1"}]),
        ("spectrometer", SPECTROMETER, [
            ("spectrum", {}, {"wavelength": [400.0, 400.5, 401.0], "counts": [12, 15, 13]}),
            ("raw", {}, {"counts": [10, 2570, 13, 65535]}),
        ], []),
        ("potentiostat", POTENTIOSTAT, [
            ("sweep", {"begin": -500, "end": 0}, {"e": [-500, 0], "i": [1234, 6], "prefix": [1e-9, 1e-6]}),
            ("column", {}, {"e": [0x7FFFE0C, 0x8000000]}),
        ], [{"done": "script", "lines": 3}, {"done": "script", "lines": 1}]),
        ("keyed", KEYED, [
            ("temperature", {}, {"t": 21.5}),
            ("dose", {}, {}),
            ("trace", {}, {"u": [0.5, -1.25, 0.125]}),
        ], [{"done": "dose", "key": "K1"}]),
        ("stepper", BUS["stepper"], [
            ("position", {}, {"x": 6}),
            ("go", {"x": -12.8}, {}),
            ("position", {}, {"x": -12.8}),
        ], [{"done": "move", "to": -2560}]),
        ("bath", BUS["bath"], [
            ("inside", {}, {"t": -38.8}),
            ("heat", {"to": -5.25}, {}),
            ("target", {}, {"t": -5.25}),
        ], [{"done": "set", "to": "FDF3"}]),
        ("plc", BUS["plc"], [
            ("level", {}, {"v": 21.5}),
            ("fill", {"to": 0.1}, {}),
            ("level", {}, {"v": 0.1}),
        ], [{"done": "fill", "to": "cccd3dcc"}]),
        ("gauges", BUS["gauges"], [
            ("pressure", {}, {"p": 1000}),
            ("switch", {"on": True}, {}),
        ], [{"done": "switch", "address": "001", "to": "1"}]),
        ("ionpump", BUS["ionpump"], [
            ("pressure", {}, {"p": 4.3e-8}),
            ("high_voltage", {"on": True}, {}),
        ], [{"done": "hv", "to": "1"}]),
        ("manometer", BUS["manometer"], [
            ("pressure", {}, {"p": 760.2}),
            ("trip", {"at": 5}, {}),
        ], [{"done": "set", "to": "5.00E+00"}]),
        ("syringe", BUS["syringe"], [
            ("go", {"to": 500}, {}),
            ("plunger", {}, {"at": 500}),
            ("state", {}, {"ready": True}),
        ], [{"done": "move", "to": 1500}]),
        ("flow", BUS["flow"], [
            ("flow", {}, {"flow": 17, "raw": [0x7E, 0x7D, 0x11, 0x13]}),
            ("set", {"to": 12.5}, {}),
        ], [{"done": "set", "to": 12.5}]),
        ("stage", BUS["stage"], [
            ("position", {}, {"x": 0.2626}),
            ("go", {"x": 0.333}, {}),
            ("position", {}, {"x": 0.333}),
        ], [{"done": "move", "to": 3330}]),
        ("sketch", BUS["sketch"], [
            ("read", {}, {"t": 21.5, "other": None, "fan": True}),
            ("heat", {"to": 60}, {}),
        ], [{"done": "heat", "to": 60}]),
        ("service", BUS["service"], [
            ("demod", {}, {"x": 1.25, "y": [0.5, 1.5]}),
            ("sweep", {"points": 300}, {}),
        ], [{"done": "sweep", "points": 300}]),
        ("acquisition", BUS["acquisition"], [
            ("input", {}, {"u": -1.3}),
            ("output", {"u": 2.5}, {}),
        ], [{"done": "out", "to": 2500}]),
        ("controller485", BUS["controller485"], [
            ("flow", {}, {"flow": 12.5}),
            ("set", {"to": 50}, {}),
        ], [{"done": "set", "to": 16000}]),
        ("dosing", BUS["dosing"], [
            ("rate", {}, {"rate": 1250}),
            ("set", {"to": 2500}, {}),
            ("rate", {}, {"rate": 2500}),
            ("dose", {"volume": -12.5}, {}),
            ("level", {}, {"volume": 12.5}),
        ], [{"done": "rate", "to": 2500}, {"done": "dose", "nl": -12500}]),
        ("thermostat", BUS["thermostat"], [
            ("temperature", {}, {"t": 21.37}),
            ("heat", {"to": 37.5}, {}),
        ], [{"done": "set", "to": "37.5"}]),
        ("weather", BUS["weather"], [
            ("temperature", {}, {"t": 21.37}),
            ("any", {"channel": 200}, {"v": 45.25}),
        ], []),
        ("mixer", BUS["mixer"], [
            ("set", {"to": 12.5}, {}),
            ("all", {}, {"n": [1, 2], "flow": [12.5, 0.5]}),
            ("pressure", {}, {"p": 1013}),
            ("air", {}, {"t": 21.5, "humidity": 40, "p": 1013}),
            ("json", {}, {"t": 21.5, "of": [1, 2]}),
        ], [{"done": "set", "to": "12.5"}]),
        ("vessel", KEYED + "expired: ^ERR KEY", [
            ("dose", {}, {}), ("dose", {}, {}), ("dose", {}, {}), ("trace", {}, {"u": [0.5, -1.25, 0.125]}),
        ], [{"done": "dose", "key": "K1"}, {"done": "dose", "key": "K1"}, {"done": "dose", "key": "K2"}]),
        ("peristaltic", BUS["peristaltic"], [
            ("rate", {}, {"rate": 0.15}),
            ("set", {"to": 2.5}, {}),
            ("rate", {}, {"rate": 2.5}),
        ], [{"done": "rate", "to": "2500+0"}]),
    ],
)  # fmt: skip
def test_what_it_reads_sets_and_refuses(peer, ask, kind, said, told, done):
    there = peer("odd_peer.py", kind=kind)

    async def story(made):
        goal = GoalContext("run/x/1")
        answers = [(n, given, await made.method(n)(goal, **given)) for n, given, _ in told]
        action, given, name, happened = REFUSED.get(kind, ("", {}, "", ""))
        if action in made.contract_kept.actions:
            with pytest.raises(ActionFailed) as refused:
                await made.method(action)(goal, **given)
            assert (refused.value.name, refused.value.happened) == (name, happened)
        return answers

    assert (
        ask(
            "text",
            {"resource": there.where, **(said if isinstance(said, dict) else said_in(said))},
            story,
        )
        == told
    )
    assert [one for one in there.done() if one["done"] != "on"] == done


def test_two_instruments_take_turns_on_one_line(peer, tmp_path):
    there = peer("odd_peer.py", kind="gauges")
    said = {**BUS["gauges"], "resource": there.where, "shared": True}
    read = {"send": "0020074002=?", "answer": "0021074006(.*)", "effect": "pure"}
    other = {**said, "actions": {"pressure": BUS["gauges"]["actions"]["pressure"] | read}}

    async def three(config, name):
        made = Text(Place(name, config, {}, tmp_path / name, tmp_path))
        await made.open()
        told = [await made.method("pressure")(GoalContext("run/x/1")) for _ in range(3)]
        await made.close()
        return {one["p"] for one in told}

    async def both():
        return await asyncio.gather(three(said, "one"), three(other, "two"))

    for name in ("one", "two"):
        (tmp_path / name).mkdir()

    assert asyncio.run(both()) == [{1000.0}, {4.321e-10}]
    assert there.done("collision") == []


def test_a_line_that_has_lost_its_beginning_is_none(tmp_path):
    """A balance that never stops: 0.34 g is the end of a line of 12.34 g."""
    said = TextConfig(resource="a:1", actions={"mass": {"answer": ".*"}})

    async def story(heard_at):
        lines = Lines(Place("balance", {}, {}, tmp_path, tmp_path), said)
        lines.channel.take(b"ST 1")
        lines.channel.heard_at = heard_at
        lines.forget()
        lines.channel.take(b"2.34 g\r\nST 12.34 g\r\n")
        return await lines.next_line(500)

    assert asyncio.run(story(heard_at=float("inf"))) == "ST 12.34 g"
    assert asyncio.run(story(heard_at=float("-inf"))) == "2.34 g"  # what stood there had ended


def test_a_stream_of_frames_is_found_from_its_middle(tmp_path):
    """Where the first sign of a frame stands within another, only the checksum tells."""
    said = TextConfig(
        resource="a:1", terminator="", frame="\x07.{4}", checksum={"of": "sum", "form": "c", "skips": 1},
        actions={"p": {"answer": "(?s).*"}},
    )  # fmt: skip

    async def story():
        lines = Lines(Place("gauge", {}, {}, tmp_path, tmp_path), said)
        lines.listening_for = lines.pattern(".*")
        lines.channel.take(b"\x07\x05\x0e" + 2 * b"\x07\x02\x07\x05\x0e")
        return await lines.next_line(500)

    assert asyncio.run(story()) == "\x07\x02\x07\x05"


def test_one_that_is_slow_to_hear_gets_a_line_sign_by_sign(tmp_path):
    said = TextConfig(resource="a:1", pace="1 ms", actions={"v": {"send": "V?"}})
    sent = []

    async def story():
        lines = Lines(Place("supply", {}, {}, tmp_path, tmp_path), said)

        async def write(data):
            sent.append(data)

        lines.channel.write = write
        await asyncio.gather(lines.send("V?"), lines.at_once("X"))

    asyncio.run(story())
    assert sorted(b"".join(sent).split()) == [b"V?", b"X"]  # an abort does not go out within a line
    assert {len(one) for one in sent} == {1}
    with pytest.raises(ValueError, match="a `pace` is kept on serial ports and by TCP"):
        TextConfig(resource="udp://a:1", pace="1 ms", actions={"v": {"send": "V?"}})


def test_code_words_stand_for_words_booleans_and_numbers():
    shutter = {"words": {"true": "OPEN", "false": "SHUT"}}
    level = {"unit": "V", "words": {"0.1": "R1", "10": "R2"}}
    said = {
        "set": {"send": "S{open},{level}", "params": {"open": shutter, "level": level}},
        "get": {"send": "?", "returns": {"open": shutter, "level": level}},
    }
    config = TextConfig(resource="a:1", terminator="CRLF", actions=said)
    contract = config.contract("shutter@1")

    assert contract.actions["set"].param_schemas() == {
        "open": {"type": "boolean", "enum": [True, False]},
        "level": {"type": "number", "enum": [0.1, 10.0], "unit": "V"},
    }
    assert (
        fill("S{open},{level}", {"open": False, "level": 10}, said["set"]["params"], "")
        == "SSHUT,R2"
    )
    assert values("open,r1", said["get"]["returns"], None) == {"open": True, "level": 0.1}
    assert config.terminators.write == "\r\n"


def test_a_sign_that_yaml_has_not_read_is_told():
    config = TextConfig(resource="a:1", actions={"x": {"send": r"\x05"}, "y": {"send": r"GO\r"}})
    told = [fault.message for fault in config.faults(config.contract("x@1"), apart=False)]

    assert len(told) == 2 and "in double quotes it is the one sign" in told[0]


def test_the_contract_has_no_word_of_how_a_value_is_written():
    contract = TextConfig(resource="a:1", **said_in(CHILLER)).contract("chiller@1")

    assert contract.actions["set_mode"].param_schemas()["mode"] == {
        "enum": ["slow", "fast"], "type": "string",
    }  # fmt: skip
    assert contract.actions["state"].returns["properties"]["pumping"] == {"type": "boolean"}
    assert contract.actions["target"].returns["properties"]["target"] == {
        "type": "number", "unit": "degC",
    }  # fmt: skip
