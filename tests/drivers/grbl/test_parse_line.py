"""Lines are understood by what they are, also where noise stands in front of them."""

import pytest

from labrun.drivers.grbl.firmware import GRBL, firmware_of
from labrun.drivers.grbl.parse_line import Lines, understand


@pytest.mark.parametrize(
    ("line", "kind", "code"),
    [
        ("ok", "ok", 0),
        ("~x#ok", "ok", 0),
        ("error:9", "error", 9),
        ("\x7ferror:22", "error", 22),
        ("ALARM:1", "alarm", 1),
        ("Grbl 1.1h ['$' for help]", "banner", 0),
        ("GrblHAL 1.1f ['$' or '$HELP' for help]", "banner", 0),
        ("[MSG:Reset to continue]", "message", 0),
        ("[MSG:this is ok", "other", 0),
        ("<Idle|MPos:0.000,0.000,0.000|FS:0,0>", "report", 0),
        ("j2<Hold:0|MPos:0.000,0.000,0.000|FS:0,0>", "report", 0),
        ("<Idle|MPos:0.000,0.0ok", "other", 0),
        ("$110=2500.000", "setting", 0),
        ("[VER:1.1h.20190830:]", "other", 0),
        ("[OPT:VZ,15,128]", "options", 0),
        (">G20G54:ok", "other", 0),
        (">FOO:error:20", "other", 0),
    ],
)
def test_a_line_is_what_it_is(line, kind, code):
    said = understand(line)

    assert (said.kind, said.code) == (kind, code)


def test_lines_come_whole_however_they_are_cut():
    lines = Lines()
    data = b"\r\nGrbl 1.1h ['$' for help]\r\nok\r\n"
    found = [line for i in range(len(data)) for line in lines.cut(data[i : i + 1])]

    assert found == ["Grbl 1.1h ['$' for help]", "ok"]


def test_unreadable_bytes_are_counted_and_left_out():
    lines = Lines()

    assert lines.cut(b"\xff\x00\x81ok\r\n") == ["ok"]
    assert lines.unreadable == 3


def test_noise_without_an_end_does_not_fill_the_memory():
    lines = Lines()
    for _ in range(50):
        lines.cut(b"\xf0" * 100)

    assert len(lines.rest) <= 1024
    assert lines.cut(b"\nok\n") == ["ok"]
    assert lines.unreadable == 5000


def test_numbers_above_grbls_own_mean_what_the_firmware_says():
    fluid = firmware_of("Grbl 4.0 FluidNC v4.0.5")

    assert GRBL.alarm(14) == "ALARM:14: the spindle did not answer"
    assert fluid.alarm(14) == "ALARM:14: it must be homed. Home it"
    assert "password" in fluid.error(110) and "password" in GRBL.error(77)
    assert (fluid.alarm(2), fluid.error(9)) == (GRBL.alarm(2), GRBL.error(9))
    assert [firmware_of(told).name for told in ("GrblHAL 1.1f", "grblHAL", "Grbl 1.1h", "gnea")] == [
        "grblHAL", "grblHAL", "GRBL", "GRBL",
    ]  # fmt: skip
