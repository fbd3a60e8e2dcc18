"""`labrun new` writes a protocol that checks clean, and overwrites nothing."""

import pytest

from labrun.engine.check import check_file, check_text
from labrun.engine.new.protocol import TEMPLATES, CannotMake, protocol_name, template_text

from ...command_line import labrun


@pytest.mark.parametrize(
    "template",
    [
        name if name in ("minimal", "dispense") else pytest.param(name, marks=pytest.mark.soak)
        for name in TEMPLATES
    ],
)
def test_a_new_protocol_checks_clean_and_runs_on_the_simulated_lab(tmp_path, template):
    made = labrun(tmp_path, "new", "my-first", "--template", template)
    path = tmp_path / "my-first.yaml"
    checked = check_file(path)
    ran = labrun(tmp_path, "my-first.yaml")

    assert made.returncode == 0
    assert made.stdout == (
        "my-first.yaml is written. Next:\n  labrun check my-first.yaml\n  labrun my-first.yaml\n"
    )
    assert checked.problems == [] and checked.protocol is not None
    assert checked.protocol.name == "my-first"
    assert ran.returncode == 0, ran.stderr


@pytest.mark.parametrize("template", TEMPLATES)
def test_every_template_is_a_clean_protocol_with_a_modeline_for_editors(template):
    text = template_text(template)

    assert text.startswith("# yaml-language-server: $schema=./labrun.schema.json\n")
    assert check_text(text, f"{template}.yaml").problems == []


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "scan.yaml").write_text("mine")
    done = labrun(tmp_path, "new", "scan.yaml")

    assert done.returncode == 2 and "scan.yaml already exists" in done.stderr
    assert (tmp_path / "scan.yaml").read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("../scan", "is a path"), ("a/b", "is a path"), ("c:\\x", "is a path"), ("", "is not a valid"),
        (".hidden", "is not a valid"), ("a:b", "is not a valid"), ("ünï", "is not a valid"),
        ("a\n", "is not a valid"), ("x" * 81, "too long"), ("NUL", "Windows"), ("a.", "is not a valid"),
    ],
)  # fmt: skip
def test_a_name_that_will_not_do_is_refused_with_a_sentence(name, reason):
    with pytest.raises(CannotMake, match=reason):
        protocol_name(name)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "on",
        "1e3",
        *(pytest.param(n, marks=pytest.mark.soak) for n in ("12", "0x1", "a b", "v1.2", "null")),
    ],
)
def test_names_that_yaml_would_read_as_something_else_stay_names(tmp_path, name):
    done = labrun(tmp_path, "new", name, "--template", "minimal")
    checked = check_file(tmp_path / f"{name}.yaml")

    assert done.returncode == 0
    assert checked.problems == [] and checked.protocol is not None and checked.protocol.name == name


def test_a_template_that_is_not_there_is_guessed(tmp_path):
    done = labrun(tmp_path, "new", "x", "--template", "grid")

    assert done.returncode == 2 and "did you mean grid_scan?" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_lab_decides_what_can_be_begun_and_who_plays(tmp_path):
    lab = "devices:\n  left: {contract: gantry@1, driver: sim_gantry}\n"
    more = "  right: {contract: gantry@1, driver: sim_gantry}\n"
    more += "  laser: {contract: libs_analyzer@1, driver: sim_libs}\n"
    (tmp_path / "small.yaml").write_text(lab)
    rest = "  red: {contract: spectrum_reducer@1, driver: reducer}\n"
    (tmp_path / "large.yaml").write_text(lab + more + rest)
    small = labrun(tmp_path, "new", "a", "--lab", "small.yaml")
    minimal = labrun(tmp_path, "new", "b", "--lab", "small.yaml", "--template", "minimal")
    large = labrun(tmp_path, "new", "c", "--lab", "large.yaml")
    checked = check_file(tmp_path / "c.yaml", lab=tmp_path / "large.yaml", bind={"gantry": "left"})

    assert small.returncode == 2 and "--template minimal fits any lab" in small.stderr
    assert minimal.returncode == 0
    assert "# The lab 'lab' has left: gantry@1." in (tmp_path / "b.yaml").read_text()
    assert "labrun check c.yaml --lab large.yaml --bind gantry=left" in large.stdout
    assert checked.problems == []
