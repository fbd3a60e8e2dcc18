"""Problems are printed as people, programs and GitHub read them."""

import io
import json

from labrun.engine.check import check_file
from labrun.engine.problems.print import print_problems

PROTOCOL = """\
labrun: 1
name: demo
params:
  dwell: {type: quantity, unit: s, default: 4 s}
devices: {gantry: gantry@1, libs: libs_analyzer@1}
steps:
  - do: gantry.move_to
    with:
      x: ${{ params.dwell }}
  - {id: shoot, do: libs.measure}
  - do: libs.export
    with:
      shot: ${{ steps.shoot.shotid }}
      file: a.csv
finally: [{do: libs.disarm}]
"""


def printed(tmp_path, monkeypatch, format: str, text: str = PROTOCOL) -> str:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "demo.yaml"
    path.write_text(text, encoding="utf-8")
    out = io.StringIO()
    print_problems(check_file(path.relative_to(tmp_path)).problems, format=format, file=out)
    return out.getvalue()


def test_text_is_what_the_design_shows(tmp_path, monkeypatch):
    assert (
        printed(tmp_path, monkeypatch, "text")
        == """\
demo.yaml:9:10: error[E204] gantry.move_to.x: 4 s is a time, the device wants a length (mm)
    9 |       x: ${{ params.dwell }}
      |          ^^^^^^^^^^^^^^^^^^^
demo.yaml:13:13: error[E301] steps.shoot.shotid: 'shoot' returns shot_id; did you mean steps.shoot.shot_id?
   13 |       shot: ${{ steps.shoot.shotid }}
      |             ^^^^^^^^^^^^^^^^^^^^^^^^^
2 errors. Nothing was sent to any device.
"""
    )


def test_json_is_a_list_of_problems(tmp_path, monkeypatch):
    first = json.loads(printed(tmp_path, monkeypatch, "json"))[0]

    assert list(first) == ["file", "line", "column", "severity", "code", "message", "hint"]
    assert (first["file"], first["line"], first["column"]) == ("demo.yaml", 9, 10)


def test_github_is_given_annotations(tmp_path, monkeypatch):
    lines = printed(tmp_path, monkeypatch, "github").splitlines()

    assert lines[0].startswith(
        "::error file=demo.yaml,line=9,col=10,title=E204::gantry.move_to.x: 4 s"
    )
    assert len(lines) == 2


def test_no_problems_are_no_text(tmp_path, monkeypatch):
    fine = PROTOCOL.replace("shotid", "shot_id").replace(
        "${{ params.dwell }}", "${{ params.dwell * 1 mm/s }}"
    )

    assert printed(tmp_path, monkeypatch, "text", fine) == ""
    assert printed(tmp_path, monkeypatch, "json", fine) == "[]\n"


def test_control_characters_of_a_file_do_not_reach_the_terminal(tmp_path, monkeypatch):
    text = printed(tmp_path, monkeypatch, "text", 'name: "\\e[31m"\nlabrun: "\\e[2J"\n\x9b')

    assert "\x1b" not in text and "\x9b" not in text


def test_a_very_long_line_is_shown_around_what_is_wrong(tmp_path, monkeypatch):
    text = printed(
        tmp_path, monkeypatch, "text", "labrun: 1\n# é\n" + '{"a": "' + "x" * 5000 + '", b: }]'
    )
    lines = text.splitlines()

    assert all(len(line) < 300 for line in lines)
    assert lines[2].index("^") < len(lines[1])
