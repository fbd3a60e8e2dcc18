"""What people write as in another language, or in their own, is told with the way on."""

import pytest

from labrun.engine.check import check_text

HEAD = "labrun: 1\nname: p\ndevices: {gantry: gantry@1, libs: libs_analyzer@1}\n"
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
    ],
)  # fmt: skip
def test_it_is_told_how_it_is_written_here(text, code, way):
    problems = check_text(HEAD + text, "p.yaml").problems

    assert [p.code for p in problems if p.code[0] == "E"] == [code]
    assert way in next(p.hint for p in problems if p.code == code)
