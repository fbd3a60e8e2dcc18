"""Values of the wrong kind, and what is written instead."""

import pytest

from labrun.engine.check import check_text


@pytest.mark.parametrize(
    ("items", "hint"),
    [
        ("range(5)", "write ${{ range(5) }}"),
        ("'${ range(5) }}'", "write ${{ range(5) }}"),
        ("'${ range(5) }'", "write ${{ range(5) }}"),
        ("five", "such as [1, 2, 3]"),
        ("5", "${{ range(5) }} has so many; `repeat: 5` needs no name"),
    ],
)
def test_a_list_that_lacks_its_braces_is_told_how_it_is_written(items, hint):
    text = f"labrun: 1\nname: p\nsteps:\n  - {{foreach: {{i: {items}}}, steps: [{{wait: 1 s}}]}}\n"

    assert [p.hint for p in check_text(text, "p.yaml").problems if p.code == "E309"] == [hint]


def test_lists_that_are_zipped_in_a_run_are_checked_without_a_fault():
    text = """labrun: 1
name: p
steps:
  - set: {a: [1], b: [2]}
  - repeat: 2
    steps: [{set: {a: "${{ a + [3] }}", b: "${{ b + [4] }}"}}]
  - log: "${{ [p[0] + p[1] for p in zip(a, b)] }}"
"""

    assert check_text(text, "p.yaml").problems == []


@pytest.mark.parametrize(
    ("condition", "hint"),
    [
        ("${{ n }} > 4", "write require: ${{ n > 4 }}"),
        ("${{ n > 4 }};", "write require: ${{ n > 4 }}"),
        ("= ${{ n > 4 }}", "write require: ${{ n > 4 }}"),
        ("${{ n > 3 }} and ${{ n < 10 }}", "write require: ${{ n > 3 and n < 10 }}"),
        ("not ${{ n > 4 }}", "write require: ${{ not n > 4 }}"),
        ("${{ n > 4 }} else stop", "write all of it between the braces"),
    ],
)
def test_a_condition_with_text_beside_its_braces_would_always_be_true(condition, hint):
    text = f"labrun: 1\nname: p\nsteps:\n  - set: {{n: 3}}\n  - require: {condition}\n"

    assert [(p.code, p.hint) for p in check_text(text, "p.yaml").problems] == [("E309", hint)]


@pytest.mark.parametrize(
    "written", ["${{ n }};", "${{ n }},", "= ${{ n }}", "${{ n }}.", "${{ n }}}"]
)
def test_what_other_languages_end_a_value_with_makes_text_of_it(written):
    text = f"labrun: 1\nname: p\nsteps:\n  - set: {{n: 3}}\noutputs:\n  a: {written}\n  b: ${{{{ n }}}} nm.\n"
    (problem,) = check_text(text, "p.yaml").problems
    beside = written.replace("${{ n }}", "").strip()

    assert (problem.code, problem.line, problem.hint) == (
        "W101",
        6,
        f"write it without the `{beside}`",
    )
