"""`labrun words` describes a protocol as a methods section would."""

from pathlib import Path

import pytest

from labrun.engine.check import check_file, check_text
from labrun.engine.views.words.act import conjugated
from labrun.engine.views.words.page import as_markdown, as_text, page
from labrun.schemas.contracts import shipped_contracts

HERE = Path(__file__).parents[1]
EXAMPLE = HERE / "examples" / "libs_grid_scan.yaml"
SHIPPED = sorted((HERE.parents[1] / "protocols").glob("*.yaml"))


def words(text: str) -> str:
    checked = check_text("labrun: 1\nname: t\n" + text, "t.yaml")
    assert checked.ok, checked.problems
    return " ".join("\n".join(as_text(page(checked))).split())


def test_the_example_reads_as_sentences():
    said = " ".join("\n".join(as_text(page(check_file(EXAMPLE)))).split())

    assert "the gantry finds the machine's zero (120 s at most), and libs finds" in said
    assert (
        "3. At each of 1,071 points of a 21 x 51 grid (snake; x from 0 mm to 4 mm in steps of "
        "0.2 mm, y from 0 mm to 10 mm in steps of 0.2 mm):" in said
    )
    assert (
        "3.2 The gantry moves to the point (x, y). If that fails with Timeout or Busy, it is "
        "tried up to 3 times in all, 1 s apart and 2 times as long after each try." in said
    )
    assert "Libs purges with argon, fires one burst, keeps the spectrum (15 s at most)." in said
    assert (
        "A point that fails for good is left out; with more than 20 of them the step fails." in said
    )
    assert "For each point a row is kept: x, y, shot, Li." in said
    assert "holes the number of turns that failed of 'scan'" in said
    assert "Enclosure closed, argon on, demo clamped?" in said


def test_values_that_are_known_are_said_and_others_are_named():
    said = words("""\
params: {x0: {type: quantity, unit: mm, default: 2 cm}}
devices: {gantry: gantry@1}
steps:
  - {id: first, do: gantry.move_to, with: {x: "${{ params.x0 + 1 mm }}"}}
  - {do: gantry.move_to, with: {y: "${{ steps.first.x + 1 mm }}"}}
  - {set: {n: 1}}
  - {while: "${{ n < 3 }}", max: 5, steps: [{set: {n: "${{ n + 1 }}"}}]}
""")

    assert "The gantry moves to x = 21 mm." in said
    assert "The gantry moves to y = the x of 'first' + 1 mm." in said
    assert "As long as n is less than 3, 5 times at most:" in said and "Let n be n + 1." in said
    assert "the step fails (MaxReached)" in said


def test_texts_have_no_syntax_of_expressions():
    said = words(
        """
params: {sample: {type: string, default: core}, who: {type: string, default: Ada}}
devices: {libs: libs_analyzer@1}
steps:
  - foreach: {point: "${{ grid(x=span(0, 1 mm, 1 mm), y=[0 mm]) }}"}
    steps:
      - {log: "${{ params.sample }} at ${{ point.ix }}, ${{ point.x + 2 mm }}"}
"""
    )

    assert "core at (point's ix), (point's x + 2 mm)" in said


def test_branches_sets_and_fallbacks_are_said():
    said = words("""\
devices: {gantry: gantry@1, libs: libs_analyzer@1}
steps:
  - any: [{do: gantry.home}, {do: libs.locate}]
  - if: ${{ run.simulated }}
    then: [{log: here}]
    else: [{log: there}, {wait: 5 s}]
  - {do: libs.locate, when: "${{ not run.simulated }}", fallback: [{do: libs.reconnect}], on_error: pause}
""")

    assert "; the first that succeeds ends the others." in said
    assert (
        "2. If the run is simulated: 2.1 It is noted: “here”. Otherwise: 2.2 It is noted:" in said
    )
    assert "2.3 The protocol waits 5 s." in said
    assert "3. Only if the run is not simulated: Libs finds" in said
    assert "If that fails, libs wakes the analyser and opens its link again." in said
    assert "the run pauses until a person continues it" in said


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_protocol_is_said_in_both_layouts(path):
    checked = check_file(path)
    text, markdown = (list(layout(page(checked))) for layout in (as_text, as_markdown))

    assert checked.protocol is not None
    assert text[0] == checked.protocol.name and max(map(len, text)) <= 100
    assert markdown[0].startswith("# ") and "## Procedure" in markdown
    assert not any("${{" in line for line in text)


def test_markdown_formats_nothing_by_accident():
    checked = check_text("labrun: 1\nname: t\nsteps: [{log: '*a* <b> [c] `d`'}]\n", "t.yaml")
    said = "\n".join(as_markdown(page(checked)))

    assert r"1. It is noted: “\*a\* \<b\> \[c\] \`d\`”." in said


@pytest.mark.parametrize("contract", shipped_contracts().values(), ids=lambda one: one.type)
def test_summaries_of_shipped_contracts_are_conjugated_whole(contract):
    for action in contract.actions.values():
        said = conjugated(action.summary)

        assert said == said.strip()


def test_every_verb_of_a_summary_is_conjugated():
    assert conjugated("Purge with argon, fire one burst, keep it") == (
        "purges with argon, fires one burst, keeps it"
    )
    assert conjugated("Go there and stand still") == "goes there and stands still"


def test_times_of_day_are_told_in_words():
    said = words(
        """devices: {balance: balance@1}
steps:
  - {id: w, do: balance.weigh}
  - set: {begun: "${{ now() }}"}
  - wait: {until: "07:00"}
  - wait: {until: "${{ begun + 5 min }}"}
  - {while: "${{ elapsed() < 8 h }}", steps: [{wait: 1 min}]}
  - {require: "${{ steps.w.took < 5 s }}"}
"""
    )

    assert "Let begun be the time of day." in said
    assert "waits until 07:00" in said and "waits until begun + 5 min" in said
    assert "As long as the time since the start is less than 8 h" in said
    assert "only if the duration of 'w' is less than 5 s" in said


def test_what_a_group_has_set_is_not_known_where_it_is_watched_or_has_failed():
    said = words("""\
devices: {gantry: gantry@1, libs: libs_analyzer@1}
steps:
  - set: {n: 0}
  - watch: [{every: 10 s, when: "${{ status.libs.argon < 1 bar }}", then: {fail: "${{ error.message }}"}}]
    steps: [{do: gantry.home}, {set: {n: "${{ n + 1 }}"}}]
    fallback: [{log: "${{ n }} times, ${{ [n, 2] }}"}, {log: "${{ error.message }}"}]
  - set: {seen: ["${{ n }}", 2], more: []}
  - log: "${{ more }}"
  - log: "${{ seen }}"
""")

    assert "“(n) times" in said and "0 times" not in said
    assert "it is noted: error's message." in said
    assert (
        "As soon as the libs's argon is less than 1 bar (looked at every 10 s; also if that" in said
    )
    assert "Let seen be the list of n and 2 and more be an empty list." in said
