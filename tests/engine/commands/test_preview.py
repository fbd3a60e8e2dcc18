"""`labrun preview` as a person runs it."""

from pathlib import Path

import pytest

from ...command_line import labrun

PROTOCOLS = Path(__file__).parents[3] / "protocols"
HEADER = "labrun: 1\nname: t\ndevices: {gantry: gantry@1}\nsteps:\n"


def test_the_picture_is_named_after_the_protocol_and_its_path_is_printed(tmp_path):
    done = labrun(tmp_path, "preview", PROTOCOLS / "hello.yaml")

    assert (done.returncode, done.stdout, done.stderr) == (0, "hello-preview.png\n", "")
    assert (tmp_path / "hello-preview.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_points_outside_the_limits_are_drawn_and_said(tmp_path):
    file = PROTOCOLS / "pegmatite_map.yaml"
    done = labrun(tmp_path, "preview", file, "-p", "x0=727 mm", "-o", "far.svg")

    assert (done.returncode, done.stdout) == (0, "far.svg\n")
    assert "error[E207]" in done.stderr
    assert "255 of 1,071 points are outside x 0..730 mm, y 0..810 mm" in done.stderr
    assert "255 outside" in (tmp_path / "far.svg").read_text(encoding="utf-8")


def test_what_hides_the_meaning_of_a_protocol_stops_it(tmp_path):
    for text in (HEADER, HEADER + "  - {dp: gantry.home}\n", "name: [\n"):
        (tmp_path / "p.yaml").write_text(text)
        done = labrun(tmp_path, "preview", "p.yaml")

        assert (done.returncode, done.stdout) == (2, "")
        assert "error[E1" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.slow
def test_where_there_is_nothing_to_draw_it_says_why(tmp_path):
    said = {
        "labrun: 1\nname: t\nsteps: [{wait: 1 s}]\n": "no device of this protocol moves in a plane",
        HEADER + "  - {do: gantry.home}\n": "no step moves gantry to an x and a y",
        HEADER + "  - {do: gantry.move_to, with: {x: 1}}\n": "the run decides where gantry goes",
    }
    for text, reason in said.items():
        (tmp_path / "p.yaml").write_text(text)
        done = labrun(tmp_path, "preview", "p.yaml")

        assert done.returncode == 2 and reason in done.stderr


def test_another_kind_of_picture_and_a_place_that_is_not_there_are_refused(tmp_path):
    other = labrun(tmp_path, "preview", PROTOCOLS / "hello.yaml", "-o", "a.bmp")
    nowhere = labrun(tmp_path, "preview", PROTOCOLS / "hello.yaml", "-o", "no/a.png")

    assert other.returncode == 2 and "must be a .png, .svg or .pdf" in other.stderr
    assert nowhere.returncode == 2 and "cannot be written" in nowhere.stderr
