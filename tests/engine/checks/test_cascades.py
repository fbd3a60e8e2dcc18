"""Each fault is reported once, without its consequences."""

import pytest

from labrun.engine.check import check_text

HEADER = "labrun: 1\nname: cascade\n"


def told(text):
    return [f"{p.code} {p.line}" for p in check_text(HEADER + text, "p.yaml").problems]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("devices: {gantry: gantry@1}\nsteps:\n  - do: gantri.home\n", "E201 5"),
        ("params: {a: {type: integer, default: 1}}\nsteps:\n  - log: ${{ params.b }}\n", "E303 5"),
        ("steps:\n  - set: {depth: 1}\n  - log: ${{ dept }}\n", "E302 5"),
        ("devices: {g: gantry@1}\nsteps:\n  - {do: g.move_to, x: 1}\n", "E110 5"),
        ("devices: {g: gantry@1}\nsteps:\n  - {do: g.home, timeout: 0}\n", "E309 5"),
        ("steps:\n  - set: {span: 1}\n", "E407 4"),
        ("steps:\n  - set: {a: 1 mm}\n  - log: ${{ a + 1 mm }}\n", "E308 5"),
        ("paramms: {a: {type: integer, default: 1}}\nsteps:\n  - log: ${{ params.a }}\n", "E110 3"),
        ("steps:\n  - Set: {a: 1}\n  - log: ${{ a }}\n  - set: {a: 2}\n", "E114 4"),
        ("steps:\n  - sset: {a: 1}\n  - log: ${{ a }}\n", "E114 4"),
        ("steps:\n  - {id:first, log: x}\n  - log: ${{ steps.first.y }}\n", "E110 4"),
        ("steps:\n  - {id: a-b, log: x}\n  - log: ${{ steps.a_b.c }}\n", "E112 4"),
    ],
)
def test_a_fault_is_told_once(text, code):
    assert told(text) == [code]


def test_a_set_of_ten_members_is_told_once_a_member():
    members = "".join(f"      - do: gantry.{a}\n" for a in ("home", "halt", "unlock"))
    text = f"devices: {{gantry: gantry@1}}\nsteps:\n  - parallel:\n{members}"

    assert told(text) == ["E402 7", "E402 8"]
