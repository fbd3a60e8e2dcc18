"""Values that YAML reads differently from how they look get a hint; legitimate text gets none."""

import pytest

from labrun.engine.check import check_text

HEAD = """labrun: 1
name: traps
params: {n: {type: number, default: 1}, b: {type: boolean, default: true}}
devices: {gantry: gantry@1}
steps:
  - {log: "${{ params.n }} ${{ params.b }}"}
  - {do: gantry.home, timeout: 2 min}
"""


def told(step: str):
    return check_text(f"{HEAD}  - {step}\n", "p.yaml").problems


@pytest.mark.parametrize(
    "text",
    [
        "on", "yes", "no", "1:30", "2026-11-21", "1_000", "0b11", "1,5 mm", "a # comment", "x{{",
        "“so” he said “so”", "Sample 007", "core-010", "v1.010", "at ${{ run.id }}#3", "a:b", "12:30 Uhr",
        "'{{ 1 + 1 }}'", "it costs 5 €", "°C, µm and Ω", "| a", "'“hello”'", "'010'", "注意：停", "a – b",
        "'${{ run.id }} {{}}'", "done:ok",
    ],
)  # fmt: skip
def test_text_where_text_is_wanted_is_left_alone(text):
    if text.startswith("| "):
        text = f"'{text}'"

    assert told(f"log: {text}") == []


@pytest.mark.parametrize(
    ("step", "hint"),
    [
        ("{do: gantry.home, timeout: 1:30}", "write 90 s or 90 min"),
        ("{wait: 1:30:00}", "write 5400 s"),
        ("{require: yes}", "YAML 1.2 reads `yes` as text; write true"),
        ("{require: Off}", "write false"),
        ("{do: gantry.move_to, with: {x: 1_000 mm}}", "write 1000 mm"),
        ("{do: gantry.move_to, with: {x: '1,5 mm'}}", "a decimal point: 1.5 mm"),
        ("{do: gantry.move_to, with: {x: 1,5 mm}}", "a decimal point: 1.5 mm"),
        ("{do: gantry.move_to, with: {x: 2026-11-21}}", "a date such as 2026-11-21 is text"),
        ("{log: 1e3}", "write '1e3'"),
        ("{log: null}", ""),
        ("{foreach: {i: [1]}, at_once: 1.5, steps: [{log: a}]}", "such as at_once: 3"),
        ("{foreach: {i: [1]}, at_once: yes, steps: [{log: a}]}", "such as at_once: 3"),
        ("{steps: [{log: a}], watch: }", "indent what belongs to it below it"),
        ("{steps: [{log: a}], reserve: null}", "indent what belongs to it below it"),
        ("{repeat: 2, watch: [{when: true, then: pause}], steps: [{log: a}]}", "with `watch`"),
        ("{wait: 1 s, mode: background}", "put a group around this step"),
        ("{steps: [pause]}", "`then: pause`"),
        ('{log: ${{ ["a"][0] }}}', "write '${{ [\"a\"][0] }}'"),
        ("{log: Hello, world}", "a comma separates entries"),
        ("{do:gantry.home}", "a space is missing after the colon: `do: gantry.home`"),
        ("{do: gantry.move_to, with: {x = 5 mm, y: 1 mm}}", "`x:`, not `x =`"),
        ('do: gantry.move_to\n    with: {x = "${{ 5 mm }}", y: 1 mm}', "`x:`, not `x =`"),
        ("{do: gantry.move_to, with: x = 5 mm}", "`x:`, not `x =`"),
        ("{ask: a, choices: [b: c]}", "`: ` makes what is before it a key"),
        ("{do\u200b: gantry.home}", "U+200B"),
        ("{do: gantry.move_to, with: {x: '${{ 2 mm − 1 mm }}'}}", "write - instead"),
    ],
)
def test_a_value_of_the_wrong_kind_says_how_it_is_read(step, hint):
    assert any(hint in problem.hint for problem in told(step))


@pytest.mark.parametrize(
    ("step", "code", "hint"),
    [
        ("{do: gantry.move_to, with: {x: 010}}", "W102", "write 10"),
        ("{log: 'at {{ here }}'}", "W101", "write ${{ here }}"),
        ("{log: “hello”}", "W103", 'write "hello"'),
    ],
)
def test_what_may_be_meant_is_a_warning(step, code, hint):
    (problem,) = told(step)

    assert (problem.code, problem.severity) == (code, "warning")
    assert hint in problem.hint


def test_what_lacks_brackets_is_told_once():
    (problem,) = told("{foreach: {p: 1, 2, 3}, steps: [{log: '1'}]}")

    assert "a list needs [brackets]" in problem.hint


def test_what_is_repaired_is_told_once():
    for step in (
        "{do: gantry.move_to, with: {x: '{{ params.n }}'}}",
        "{do: gantry.move_to, with: {x: {{ params.n }}}}",
        "when: ${{ params.b #c }}\n    do: gantry.home\n    timeout: 2 min",
    ):
        assert [problem.code for problem in told(step)] == ["E109"]


def test_zeros_say_what_older_tools_read():
    (octal,), (decimal,) = (
        told(f"{{do: gantry.move_to, with: {{x: {x}}}}}") for x in ("010", "08")
    )

    assert "10; YAML 1.1 reads 8" in octal.message
    assert "YAML 1.1" not in decimal.message
