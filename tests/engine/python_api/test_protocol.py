"""Protocols built in Python: the YAML that a person would write, checked and run like a file."""

from pathlib import Path

import numpy as np
import pytest

import labrun
from labrun.engine.check import check_file, check_text
from labrun.engine.language.source import parse_source, read_source
from labrun.engine.views.explain import explain_protocol
from labrun.schemas.quantity import quantity

Do, Foreach, If, Log, Wait = (
    getattr(labrun.steps, n) for n in ("Do", "Foreach", "If", "Log", "Wait")
)
SHIPPED = sorted(
    path
    for path in (Path(labrun.__file__).parent / "protocols").rglob("*.*")
    if path.suffix in (".yaml", ".json") and "labs" not in path.parts
)
WRITTEN = """labrun: 1
name: scan
params:
  pitch: {type: quantity, unit: mm, default: 0.5 mm}
devices: {gantry: gantry@1}
steps:
  - do: gantry.home
  - id: scan
    foreach: {n: [0, 1, 2]}
    key: ${{ n }}
    steps:
      - id: go
        do: gantry.move_to
        with: {x: '${{ n * params.pitch }}', y: 1 mm}
        timeout: 30 s
        retry: 3
      - {id: rest, when: '${{ n > 1 }}', wait: 10 ms}
    collect: {x: '${{ steps.go.x }}'}
  - if: ${{ params.pitch > 1 mm }}
    then:
      - log: 'yes'
finally:
  - do: gantry.home
outputs: {points: '${{ steps.scan.total }}'}
"""


def built(x="${{ n * params.pitch }}"):
    return labrun.Protocol(
        "scan",
        params={"pitch": {"type": "quantity", "unit": "mm", "default": quantity(0.5, "mm")}},
        devices={"gantry": "gantry@1"},
        steps=[
            Do("gantry.home"),
            Foreach(
                {"n": np.arange(3)},
                id="scan",
                key="${{ n }}",
                steps=[
                    Do(
                        "gantry.move_to",
                        id="go",
                        with_={"x": x, "y": "1 mm"},
                        timeout="30 s",
                        retry=3,
                    ),
                    Wait("10 ms", id="rest", when="${{ n > 1 }}"),
                ],
                collect={"x": "${{ steps.go.x }}"},
            ),
            If("${{ params.pitch > 1 mm }}", then=[Log("yes")]),
        ],
        finally_=[{"do": "gantry.home"}],
        outputs={"points": "${{ steps.scan.total }}"},
    )


def test_it_becomes_the_yaml_that_a_person_would_write():
    assert built().dump() == WRITTEN


def test_it_is_checked_and_rehearsed_like_a_file():
    assert labrun.check(built()).problems == labrun.check(built()).problems == []
    assert labrun.rehearse(built(), pitch="1 mm")["actions"] == {
        "gantry.home": 2, "gantry.move_to": 3,
    }  # fmt: skip


def test_a_problem_shows_the_line_of_what_it_became():
    said = str(labrun.check(built(x=quantity(1, "s"))))

    assert "scan (built in Python):14:19: error[E204] gantry.move_to.x: 1 s is a time" in said
    assert "   14 |         with: {x: 1 s, y: 1 mm}" in said


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.name)
def test_what_is_read_and_written_again_checks_and_explains_equally(path, tmp_path):
    again = labrun.Protocol.read(path).dump()
    name = str(path.with_suffix(".yaml"))
    data = [read_source(path)[0].data, parse_source(again, Path(name), name)[0].data]
    checked = [check_file(path, needed=False), check_text(again, name)]
    problems = [[(p.code, p.message) for p in one.problems] for one in checked]

    assert {key: value for key, value in data[0].items() if value} == data[1]
    assert sorted(problems[0]) == sorted(problems[1])
    assert not checked[0].ok or [*explain_protocol(checked[0])] == [*explain_protocol(checked[1])]


def test_what_is_written_is_read_again(tmp_path):
    built().save(tmp_path / "scan.yaml")

    assert labrun.Protocol.read(tmp_path / "scan.yaml").dump() == WRITTEN
    (tmp_path / "bad.yaml").write_text("labrun: 1\nname: bad\nstep: []\n")
    with pytest.raises(labrun.ProtocolFault, match="unknown key 'step'"):
        labrun.Protocol.read(tmp_path / "bad.yaml")


def test_texts_that_begin_with_a_sign_of_yaml_are_read_as_they_were_given():
    texts = [":MEAS:VOLT?", "? why", "?", ":", "- a", "yes", "it's: {so}", "#1", ""]
    protocol = labrun.Protocol(
        name="a", steps=[Log(text, id=f"step_{n}") for n, text in enumerate(texts)]
    )
    said = [
        step["log"]
        for step in parse_source(protocol.dump(), Path("a.yaml"), "a.yaml")[0].data["steps"]
    ]

    assert said == texts


def test_what_yaml_has_no_word_for_is_a_mistake_of_the_program():
    with pytest.raises(TypeError, match="no value of a protocol"):
        labrun.Protocol("scan", steps=[Wait(object())]).dump()
