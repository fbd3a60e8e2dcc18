"""What people write as in another language, or in their own, is told with the way on."""

import pytest

from labrun.engine.check import check_text

DEVICES = "devices: {gantry: gantry@1, libs: libs_analyzer@1}\n"
HEAD = f"labrun: 1\nname: p\n{DEVICES}"
HOME = "{do: gantry.home}"


@pytest.mark.parametrize(
    ("text", "code", "way"),
    [
        (f"steps:\n  - {HOME}\n  - finally: [{HOME}]\n", "E114", "first column, beside `steps`"),
        (f"steps:\n  - if: ${{{{ 1 > 2 }}}}\n    then: [{HOME}]\n    elif: x\n", "E110", "write `else: "),
        (f"steps:\n  - {{every: 5 s, steps: [{HOME}]}}\n", "E110", "`while` with a `wait`"),
        (f"steps:\n  - {{try: [{HOME}]}}\n", "E114", "its own `fallback: [...]`"),
        (f"steps:\n  - repeat: {{until: x}}\n    steps: [{HOME}]\n", "E112", "`while: ${{ ... }}` repeats"),
        ("steps:\n  - {do: gantry.home, on_error: ignore}\n", "E112", "such as on_error: continue; "),
        ("steps:\n  - {do: gantry.home, collect: {x: 1}}\n", "E110", "allowed here: id, "),
        ("steps: [{do: gantry.move_to, with: {x: '${ params.x }'}}]\n", "E206", "write ${{ params.x }}"),
        ("steps: [{do: gantry.move_to, with: {x: far}}]\n", "E206", "or ${{ far }} for what the name far"),
        ("steps: [{do: gantry.move_to, with: {x: yes}}]\n", "E206", "such as x: 1 mm, or ${{ yes }} for"),
        ("params: {n: 1e3}\nsteps: [{wait: 1 s}]\n", "E112", "write {type: number, default: 1000}"),
        ("params: {n: 1_000}\nsteps: [{wait: 1 s}]\n", "E112", "write {type: integer, default: 1000}"),
        ("params: {at: 07:00}\nsteps: [{wait: 1 s}]\n", "E112", "write {type: string, default: '07:00'}"),
        ("steps: [{id: Größe, do: gantry.home}]\n", "E112", "write Groesse"),
        ("steps: [{ask: Which?}]\n", "E111", "such as choices: [good, bad]"),
        ("steps: [{confirm: true}]\n", "E112", "such as confirm: The door is closed"),
        ("steps: [{require: '${{ gantry.x > 1 mm }}'}]\n", "E302", "tells is status.gantry.FIELD"),
        (f"steps: [{{foreach: {{x: [1 mm], y: [2 mm]}}, steps: [{HOME}]}}]\n", "E112", "a loop within"),
        ("steps: [{uses: gantry.home}]\n", "E114", "write `do: gantry.home`"),
        ("steps: [{run: python a.py}]\n", "E114", "one of `functions`"),
        (f"steps: [{HOME}, {{do: libs.locate, needs: a}}]\n", "E110", "in the order in which they stand"),
        ("steps: [{while: '${{ 1 < 2 }}', max: 3, steps: [break]}]\n", "E113", "when its `while:` is"),
        ("steps: [{id: w, do: libs.measure}, {log: '${{ steps.w.result.shot_id }}'}]\n", "E301",
         "write steps.w.shot_id"),
        ("steps: [{do: gantry.move_to, with: {x: '${{ env.PITCH }}'}}]\n", "E302", "is params.PITCH"),
        ("steps: [{id: w, do: libs.measure}, {log: '${{ step.w.shot_id }}'}]\n", "E302", "write steps.w"),
        ("steps: [{wait: '${{ status.gantry.homed }}'}]\n", "E309", "waits for a condition"),
        ("devices: {gantry: {contract: gantry@1}}\nsteps: [{wait: 1 s}]\n", "E112", "write only gantry@1"),
        ("steps: [{do: libs.measure, fallback: {do: libs.locate}}]\n", "E112", "put [ and ] around it"),
        ("steps:\n  // home it\n  - {do: gantry.home}\n", "E101", "a comment begins with `#`"),
        ("% home it\nsteps: [{do: gantry.home}]\n", "E101", "a comment begins with `#`"),
    ],
)  # fmt: skip
def test_it_is_told_how_it_is_written_here(text, code, way):
    head = HEAD.replace(DEVICES, "") if text.startswith("devices") else HEAD
    problems = check_text(head + text, "p.yaml").problems

    assert [p.code for p in problems if p.code[0] == "E"] == [code]
    assert way in next(p.hint for p in problems if p.code == code)


@pytest.mark.parametrize(
    ("expression", "way"),
    [
        ("always()", "under `finally`"),
        ("str(1)", "format(x) makes text"),
        ("a(2)", "an item of a list is a[2], and the first is a[0]"),
        ("a.append(3)", "values have no methods; a list grows by a + [x]"),
        ("a.upper()", "values have no methods"),
        ("f'shot {a}'", "values within it by ${{ }}"),
        ("1 ~= 2", "write `!=`"),
        ("a += 1", "write a + 1"),
        ("0:0.5:4", "write span(0, 4, 0.5)"),
        ("gantry.home()", "an action is a step"),
    ],
)
def test_an_expression_of_another_language_is_told_how_it_is_written_here(expression, way):
    text = f'{HEAD}steps:\n  - set: {{a: [1]}}\n  - log: "${{{{ {expression} }}}}"\n'

    (problem,) = [p for p in check_text(text, "p.yaml").problems if p.code == "E300"]

    assert way in f"{problem.message} {problem.hint}"


D = "labrun: 1\nname: p\ndevices: {d: dispenser@1, g: gantry@1}\nsteps:\n"
LOOP = "{foreach: {well: [A1, A2]}, steps: [{do: d.dispense, with: {liquid: dye, volume: 5, into: IT}}]}"


@pytest.mark.parametrize(
    ("step", "told"),
    [
        (LOOP.replace("IT", "well"), "of the loop"),
        (LOOP.replace("IT", "'p_{well}'"), "with one brace"),
        ("{log: 'made {run} of {params.n} and {what}'}", "`{params.n}` with one brace"),
        (LOOP.replace("IT", "well").replace("}}]", "}}, {log: '${{ well }}'}]"), ""),
        (LOOP.replace("IT", "'${{ well }}'"), ""),
        ("{log: '{what} {} { x }'}", ""),
        ("{foreach: {x: [1, 2]}, steps: [{do: g.jog, with: {axis: x, distance: 1 mm}}]}", ""),
        ("{foreach: {x: [1]}, steps: [{log: '\\\\alpha_{x} is ${{ x }}'}]}", ""),
    ],
)  # fmt: skip
def test_a_name_that_is_left_as_text_is_told_where_nothing_else_would_find_it(step, told):
    problems = check_text(f"{D}  - {step}\n", "p.yaml").problems

    found = [p.message for p in problems if p.code == "W101"]
    assert len(found) == bool(told), problems
    assert told in "".join(found)
