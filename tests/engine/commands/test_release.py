"""A release is what a person has read, and is used up by one start."""

import sys

import pytest
import typer

from labrun.engine.commands.release import release
from labrun.engine.run.folder import FolderFault
from labrun.engine.run.released import put_back, releases, take

INNER = "labrun: 1\nname: in\ndevices: {gantry: gantry@1}\nsteps: [{do: gantry.move_to, with: {x: 3 mm}}]\n"
OUTER = "labrun: 1\nname: outer\ndevices: {gantry: gantry@1}\nsteps: [{use: inner.yaml}]\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of protocols, with a person at the terminal."""
    module = sys.modules[release.__module__]
    monkeypatch.setattr(module, "at_a_terminal", lambda: True)
    (tmp_path / "inner.yaml").write_text(INNER)
    (tmp_path / "outer.yaml").write_text(OUTER)
    return tmp_path


def test_what_is_changed_while_a_person_reads_is_not_released(folder, monkeypatch, capsys):
    def swapped(question):
        (folder / "inner.yaml").write_text(INNER.replace("3 mm", "300 mm"))
        return "release"

    monkeypatch.setattr(typer, "prompt", swapped)
    release(folder / "outer.yaml", runs=folder / "runs")
    (known,) = releases(folder / "runs")
    taken, copy = take(folder / "runs", known.id)

    assert "3 mm" in capsys.readouterr().out
    assert [path.read_text() for path in (copy / "used").iterdir()] == [INNER]
    assert taken == known and known.roles == {"gantry": "gantry"}


def test_a_release_is_taken_once_and_put_back_where_no_run_came_of_it(folder, monkeypatch):
    runs = folder / "runs"
    monkeypatch.setattr(typer, "prompt", lambda question: "release")
    release(folder / "outer.yaml", runs=runs)
    (known,) = releases(runs)
    _, copy = take(runs, known.id)

    assert releases(runs) == []
    with pytest.raises(FolderFault, match="nobody has released"):
        take(runs, known.id)
    put_back(copy)
    assert releases(runs) == [known]


def test_any_other_word_releases_nothing(folder, monkeypatch):
    monkeypatch.setattr(typer, "prompt", lambda question: "yes")
    with pytest.raises(typer.Exit):
        release(folder / "outer.yaml", runs=folder / "runs")

    assert [*(folder / "runs" / ".released").iterdir()] == []
