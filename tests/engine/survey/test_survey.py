"""Which names are visible where: forwards, out of groups, never out of loops or fallbacks."""

import textwrap

import pytest

from labrun.engine.check import check_text


def codes(steps: str, rest: str = "") -> list[str]:
    text = (
        "labrun: 1\nname: t\ndevices: {gantry: gantry@1, libs: libs_analyzer@1, reduce: spectrum_reducer@1}\n"
        "params: {n: {type: integer, default: 2}, w: {type: quantity, unit: mm, default: 4 mm}}\n"
        f"{rest}"
        f"steps:\n{textwrap.indent(textwrap.dedent(steps).strip(), '  ')}\n"
    )
    return [p.code for p in check_text(text, "t.yaml").problems if not p.code.startswith("W")]


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        ("- {set: {far: '${{ params.w * 2 }}'}}\n- {do: gantry.move_to, with: {x: '${{ far }}'}}", []),
        ("- {do: gantry.move_to, with: {x: '${{ far }}'}}\n- {set: {far: 3}}", ["E305"]),
        ("- {set: {far: 3 m}}\n- {do: gantry.move_to, with: {x: '${{ far }}'}}", ["E207"]),
        ("- {set: {t: '${{ 3 s }}'}}\n- {do: gantry.move_to, with: {x: '${{ t }}'}}", ["E204"]),
        ("- steps: [{id: a, do: libs.measure}]\n- {log: '${{ steps.a.shot_id }}'}", []),
        ("- {id: a, steps: [{do: libs.measure}]}\n- {log: '${{ steps.a.shot_id }}'}", []),
        ("- {id: a, steps: [{do: libs.measure}]}\n- {log: '${{ steps.a.shot }}'}", ["E301"]),
        ("- {id: a, ask: Which?, choices: [x, y]}\n- {log: '${{ steps.a.choice }}'}", []),
        ("- {id: a, confirm: Sure?}\n- {log: '${{ steps.a.answer }}'}", ["E301"]),
        ("- {id: a, foreach: {i: [1]}, steps: [{log: x}]}\n- {log: '${{ steps.a.failed + 1 }}'}", []),
        ("- parallel: [{do: gantry.home}, {id: a, do: libs.measure}]\n- {log: '${{ steps.a.shot_id }}'}", []),
        ("- foreach: {p: [1, 2]}\n  steps:\n    - {do: gantry.move_to, with: {x: '${{ p }}'}}", []),
        ("- foreach: {p: ['a', 2]}\n  steps:\n    - {do: gantry.move_to, with: {x: '${{ p }}'}}", ["E206"]),
        ("- foreach: {d: [{a: x, b: 1}, {a: y, c: z}]}\n  steps: [{log: '${{ d.a }}'}]", []),
        ("- foreach: {d: [{a: x, b: 1}, {a: y, c: z}]}\n  steps: [{log: '${{ d.aa }}'}]", ["E301"]),
        ("- foreach: {d: [{a: x}, {a: y, c: z}]}\n  steps: [{log: '${{ d.c }}'}]", ["E307"]),
        ("- foreach: {d: [{A: x, b: '${{run.id}}'}, {a: y, b: z}]}\n  steps: [{log: '${{d.a}}'}]", ["E301"]),
        ("- foreach: {d: [{c1: '${{ run.id }}'}, {c2: y}]}\n  steps: [{log: '${{ d.c1 }}'}]", []),
        ("- {log: '${{ run.id }} ${{ run.simulated }} ${{ run.nam }}'}", ["E301"]),
        ("- do: libs.measure\n  fallback: [{fail: '${{ error.name }}: ${{ error.message }}'}]", []),
        ("- do: libs.measure\n  fallback: [{fail: '${{ error.what }}'}]", ["E301"]),
        ("- {do: gantry.move_to, when: '${{ params.n > 1 }}', with: {x: '${{ params.w / params.n }}'}}", []),
        ("- {do: gantry.move_to, with: {x: '${{ params.w * params.w }}'}}", ["E204"]),
        ("- {do: gantry.move_to, with: {x: '${{ params.w * params.w / 2 mm }}'}}", []),
        ("- {do: gantry.move_to, timeout: '${{ params.n * 10 }}', with: {x: 1}}", []),
        ("- {do: gantry.move_to, timeout: '${{ params.w }}', with: {x: 1}}", ["E309"]),
        ("- {wait: '${{ params.n * 1 s }}'}", []),
        ("- {wait: -3 s}", ["E309"]),
        ("- {require: '${{ params.w < 1 m }}'}", []),
        ("- {log: '${{ params }}'}", ["E302"]),
        ("- {log: '${{ n }}'}", ["E302"]),
        ("- {log: '${{ len }}'}", ["E302"]),
        ("- {log: '${{ [1, 2][params.w] }}'}", ["E307"]),
        ("- {log: '${{ params.n[0] }}'}", ["E308"]),
        (
            "- foreach: {i: '${{ range(3) }}'}\n  steps:\n    - foreach: {j: '${{ range(i + 1) }}'}\n"
            "      key: '${{ j }}'\n      steps:\n"
            "        - {do: gantry.move_to, with: {x: '${{ i * 500 }}'}}",
            ["E207"],
        ),
        (
            "- foreach: {p: '${{ grid(x=span(0, 4, 1), y=span(0, 4, 1)) }}'}\n  steps:\n"
            "    - {do: gantry.move_to, with: {x: '${{ (p.x - 2) * (p.x - 2) * 200 }}'}}",
            ["E207"],
        ),
        (
            "- foreach: {p: '${{ grid(x=[0, 900, 1], y=[1]) }}'}\n  steps:\n"
            "    - {do: gantry.move_to, with: {x: '${{ p.x }}'}}",
            ["E207"],
        ),
        (
            "- foreach: {p: [1, 2, 3]}\n  steps:\n"
            "    - {do: gantry.move_to, with: {x: '${{ 4 / (p - 2) }}'}}",
            ["E207", "E307"],
        ),
        (
            "- foreach: {p: [1]}\n  steps:\n"
            "    - {id: r, do: reduce.reduce, mode: background, with: {spectrum: a}}\n"
            "  collect: {li: '${{ steps.r.areas.Li }}', t: '${{ steps.r.temprature }}'}",
            ["E301"],
        ),
    ],
)  # fmt: skip
def test_what_may_be_named_and_computed(steps, expected):
    assert codes(steps) == expected


def test_a_fault_at_one_grid_point_names_the_point():
    text = """\
labrun: 1
name: t
params: {width: {type: quantity, unit: mm, default: 732 mm}}
devices: {gantry: gantry@1}
steps:
  - foreach: {point: "${{ grid(x=span(0, params.width, 4), y=span(0, 10, 0.2)) }}"}
    steps:
      - {do: gantry.move_to, with: {x: "${{ point.x }}", y: "${{ point.y }}"}}
""".replace("width, 4)", "width, 4 mm)")
    problems = check_text(text, "t.yaml").problems

    assert [p.message for p in problems] == [
        "gantry.move_to.x: grid point 183 (732, 0.0) is outside x 0..730 mm"
    ]


def test_finally_and_outputs_know_the_results_of_the_steps_and_on_resume_does_not():
    steps = "- {id: a, do: libs.measure}"
    use = "log: '${{ steps.a.shot_id }}'"

    assert codes(steps, f"finally: [{{{use}}}]\n") == []
    assert codes(steps, "outputs: {a: '${{ steps.a.shot_id }}'}\n") == []
    assert codes(steps, f"on_resume: [{{{use}}}]\n") == ["E305"]
    assert codes("- {log: '${{ steps.z.x }}'}", "on_resume: [{id: z, do: libs.measure}]\n") == [
        "E306"
    ]


def test_what_could_not_be_read_is_not_told_again_of_those_who_use_it():
    steps = "- {id: a, doo: libs.measure}\n- {log: '${{ steps.a.shot_id }}'}"

    assert codes(steps) == ["E114"]
    assert codes("- {log: '${{ params.p }}'}", "").count("E303") == 1
