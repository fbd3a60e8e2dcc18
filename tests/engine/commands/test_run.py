"""`labrun run`: an answer that no question takes is told before anything begins, and why a run ended."""

import errno
import os

import pytest
import typer

from labrun.engine.check import check_file
from labrun.engine.commands.checked_protocol import fitting_answers
from labrun.engine.commands.resume import resume
from labrun.engine.commands.run import begin, in_words
from labrun.engine.journal.journal import JournalFault, NotWritten
from labrun.engine.run.folder import FolderFault
from labrun.engine.runner.begin import RunOptions

INNER = "labrun: 1\nname: inner\nsteps: [{id: deep, ask: Which?, choices: [x, y]}]\n"
OUTER = """labrun: 1
name: outer
devices: {balance: balance@1}
steps:
  - {id: core, ask: Which core?, choices: [A, B]}
  - {id: closed, confirm: Is it closed?}
  - {ask: And which is this?, choices: [C, D]}
  - {id: weight, do: balance.weigh}
  - {use: ./inner.yaml}
"""


@pytest.fixture
def checked(tmp_path):
    (tmp_path / "inner.yaml").write_text(INNER)
    (tmp_path / "outer.yaml").write_text(OUTER)
    return check_file(tmp_path / "outer.yaml")


def test_answers_to_every_kind_of_question_are_taken(checked):
    given = ["core=A", "closed=yes", "2=D", "weight=repeat", "deep=y"]

    assert fitting_answers(given, checked) == dict(one.split("=") for one in given)
    assert fitting_answers(None, checked) == {}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("core=a", "'a' is not among A and B; did you mean A?"), ("closed=maybe", "not among no and yes"),
        ("deep=z", "'z' is not among x and y"), ("cores=A", "no step has the id 'cores'; did you mean core?"),
    ],
)  # fmt: skip
def test_an_answer_that_no_question_takes_ends_the_command(checked, given, words, capsys):
    with pytest.raises(typer.Exit):
        fitting_answers([given], checked)

    assert words in capsys.readouterr().err


def test_a_journal_that_cannot_be_written_says_nothing_of_what_was_sent():
    unwritten = in_words(NotWritten("cannot write journal.jsonl: Input/output error"))

    assert "sent" not in unwritten
    assert unwritten.endswith("When that is cured, `labrun resume last` continues the run.")
    assert in_words(JournalFault("record 3 is damaged")) == "record 3 is damaged. Nothing was sent."


def test_a_run_that_has_no_room_to_begin_names_its_folder_and_leaves_none(
    checked, tmp_path, monkeypatch
):
    def full(*given):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("labrun.engine.runner.begin.keep", full)

    with pytest.raises(FolderFault, match=r"cannot begin .*outer_\w+: No space left on device"):
        begin(checked, tmp_path / "runs", {}, RunOptions())
    assert not list((tmp_path / "runs").iterdir())


def test_a_run_that_cannot_be_locked_is_a_sentence(tmp_path, capsys):
    (tmp_path / "journal.jsonl").touch()
    (tmp_path / "engine.lock").mkdir()

    with pytest.raises(typer.Exit) as end:
        resume(str(tmp_path))

    assert end.value.exit_code == 2
    assert f"{tmp_path / 'engine.lock'}: " in capsys.readouterr().err
