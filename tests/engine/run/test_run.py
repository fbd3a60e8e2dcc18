"""A run and its watchers: nothing of the run depends on them."""

import logging
import subprocess
import sys
from pathlib import Path

import pytest

from labrun.engine.journal.history import History
from labrun.engine.journal.journal import Journal, read_records
from labrun.engine.run.questions import Questions
from labrun.engine.run.run import Run

HELLO = Path(__file__).parents[3] / "protocols" / "hello.yaml"


@pytest.fixture
def run(tmp_path):
    journal = Journal(tmp_path / "journal.jsonl", sync=False)
    yield Run("r", tmp_path, journal, History(), {}, {}, {}, Questions())
    journal.close()


def test_a_watcher_that_fails_hears_nothing_more_and_the_others_hear_all(run, caplog):
    heard = []

    def broken(event):
        raise RuntimeError("the lamp of the watcher is out")

    run.listen(broken)
    run.listen(heard.append, ["log"])
    run.log("one")
    run.tell("step", "main/wait", "running")
    run.log("two")

    assert [event.text for event in heard] == ["one", "two"]
    (record,) = caplog.records
    assert "a watcher of the run failed" in record.getMessage()
    assert "lamp of the watcher" in str(record.exc_info[1])


def test_a_watcher_that_fails_while_it_makes_the_run_tell_more_is_dropped_once(run, caplog):
    def broken(event):
        if event.text == "one":
            run.log("heard")
        raise RuntimeError("the lamp of the watcher is out")

    run.listen(broken)
    run.log("one")

    assert run.listeners == {} and "watcher of the run failed" in caplog.text


def test_a_reader_that_has_gone_is_no_fault(run, caplog):
    def gone(event):
        raise BrokenPipeError

    run.listen(gone)
    with caplog.at_level(logging.DEBUG):
        run.log("one")

    assert run.listeners == {} and caplog.records == []


@pytest.mark.slow
@pytest.mark.posix("a closed pipe of POSIX")
@pytest.mark.parametrize("screen", [["--json"], []])
def test_a_run_whose_output_nobody_reads_any_more_goes_on_to_its_end(tmp_path, screen):
    process = subprocess.Popen(
        [sys.executable, "-m", "labrun.engine", "run", str(HELLO), *screen, "--runs", str(tmp_path)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    process.stdout.readline()
    process.stdout.close()
    told = process.stderr.read().decode()
    process.stderr.close()
    status = process.wait(100)
    (journal,) = tmp_path.glob("*/journal.jsonl")
    last = list(read_records(journal))[-1]

    assert (last.kind, last.fate) == ("finished", "succeeded")
    assert status == 0 and "Traceback" not in told
