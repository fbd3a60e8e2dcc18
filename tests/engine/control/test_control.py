"""Pause, continue, abort and answer: from another shell, by signals, and twice."""

import json
import signal
import socket
import subprocess
import sys
import time

import pytest

from labrun.engine.control.server import NotLive, Silent, ask_run
from labrun.engine.journal.journal import read_records
from labrun.engine.run.folder import FolderLock

from ...ctrl_c import TO_ONE

COMMAND = [sys.executable, "-m", "labrun.engine"]
HEADER = "labrun: 1\nname: live\ndevices: {a: scripted@1, b: scripted@1}\n"
LONG = """
steps:
  - foreach: {i: "${{ range(100000) }}"}
    steps: [{do: a.act, with: {name: "x${{ i }}", seconds: 0.02}}]
finally: [{do: b.act, with: {name: last}}]
"""


BEGUN = []
"""The runs of a test; none outlives it."""


@pytest.fixture(autouse=True)
def ended():
    yield
    while BEGUN:
        process = BEGUN.pop()
        process.kill()
        process.wait()
        process.stdout.close()


class Live:
    """A run in its own process."""

    def __init__(self, tmp_path, bench, body, *more):
        self.folder, self.bench = tmp_path, bench
        (tmp_path / "live.yaml").write_text(HEADER + body)
        self.process = subprocess.Popen(
            [*COMMAND, "run", "live.yaml", "--lab", str(bench.lab), "--json", *more],
            cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        self.events = []
        BEGUN.append(self.process)

    def wait_for(self, kind, state=None, text=""):
        for line in self.process.stdout:
            event = json.loads(line)
            self.events.append(event)
            if event["event"] == kind and state in (None, event["state"]) and text in event["path"]:
                return event
        raise AssertionError(f"the run ended without {kind} {state}")

    def tell(self, *words):
        return subprocess.run(
            [*COMMAND, words[0], "last", *words[1:]],
            cwd=self.folder, capture_output=True, text=True,
        )  # fmt: skip

    def end(self):
        self.process.communicate()
        (run,) = (self.folder / "runs").iterdir()
        self.records = list(read_records(run / "journal.jsonl"))
        self.calls = self.bench.calls(run.name)
        return self.process.returncode


def kinds(records):
    return [record.kind for record in records]


@pytest.mark.slow
def test_an_abort_from_another_shell_runs_finally_and_makes_the_devices_safe(tmp_path, bench):
    live = Live(tmp_path, bench, LONG)
    live.wait_for("goal", "succeeded")

    told = live.tell("abort")

    assert told.returncode == 0
    assert "aborting" in told.stdout
    assert live.end() == 1
    assert live.records[-1].fate == "aborted"
    assert [c["name"] for c in live.calls][-1] == "last"
    assert kinds(live.records).count("safe") == 2


@pytest.mark.slow
def test_a_paused_run_finishes_what_runs_and_then_sends_nothing(tmp_path, bench):
    live = Live(tmp_path, bench, LONG)
    live.wait_for("goal", "succeeded")

    live.tell("pause")
    time.sleep(0.3)
    sent = len(live.bench.calls())
    time.sleep(0.3)
    still = len(live.bench.calls())
    live.tell("continue")
    live.wait_for("control", "continue")
    live.wait_for("goal", "succeeded")
    live.tell("abort")

    assert still == sent
    assert live.end() == 1
    verbs = [record.verb for record in live.records if record.kind == "control"]
    assert verbs == ["pause", "continue", "abort"]
    assert f"(labrun abort on {socket.gethostname()})" in live.records[-1].reason


@TO_ONE
def test_ctrl_c_aborts_with_130_and_sigterm_with_1(tmp_path, bench):
    for name, number, status in (("c", signal.SIGINT, 130), ("t", signal.SIGTERM, 1)):
        folder = tmp_path / name
        folder.mkdir()
        live = Live(folder, bench, LONG)
        live.wait_for("goal", "succeeded")

        live.process.send_signal(number)

        assert live.end() == status
        assert [c["name"] for c in live.calls][-1] == "last"


@TO_ONE
def test_a_second_ctrl_c_is_immediate_but_still_makes_the_devices_safe(tmp_path, bench):
    live = Live(
        tmp_path, bench,
        "steps: [{do: a.shoot, with: {name: x, seconds: 60}}]\nfinally: [{do: b.act, with: {name: last}}]\n",
    )  # fmt: skip
    live.wait_for("feedback")  # the shot has begun

    live.process.send_signal(signal.SIGINT)
    live.wait_for("control", "abort")
    began = time.monotonic()
    live.process.send_signal(signal.SIGINT)

    assert live.end() == 130
    assert time.monotonic() - began < 30  # not until the shot's sixty seconds are over
    assert "last" not in [c["name"] for c in live.calls]
    assert "safe" in kinds(live.records)
    assert live.records[-1].fate == "aborted"


@pytest.mark.slow
def test_a_question_is_answered_from_another_shell(tmp_path, bench):
    live = Live(
        tmp_path, bench,
        "steps:\n  - {id: sure, confirm: 'Sure?'}\n  - {do: a.act, with: {name: x}}\n",
    )  # fmt: skip
    live.wait_for("question", "open")

    wrong = live.tell("answer", "sure", "perhaps")
    unknown = live.tell("answer", "shure", "yes")
    right = live.tell("answer", "sure", "yes")

    assert (wrong.returncode, unknown.returncode, right.returncode) == (2, 2, 0)
    assert "choose yes, no" in wrong.stderr
    assert "open: sure" in unknown.stderr
    assert live.end() == 0
    answered = [record for record in live.records if record.kind == "answered"]
    assert [record.choice for record in answered] == ["yes"]
    assert answered[0].by.endswith(f"(labrun answer on {socket.gethostname()})")


def test_an_unanswered_question_fails_at_its_timeout_and_finally_runs(tmp_path, bench):
    live = Live(
        tmp_path, bench,
        "steps: [{id: sure, confirm: 'Sure?', timeout: 0.4 s}]\n"
        "finally: [{do: b.act, with: {name: last}}]\n",
    )  # fmt: skip

    assert live.end() == 1
    assert "Timeout" in live.records[-1].detail
    assert live.calls[0]["name"] == "last"


@pytest.mark.slow
def test_on_error_pause_holds_and_continue_tries_the_step_again(tmp_path, bench):
    live = Live(
        tmp_path, bench,
        "steps: [{do: a.act, with: {name: x, script: 'Broken,ok'}, on_error: pause}]\n",
    )  # fmt: skip
    live.wait_for("control", "pause")

    told = live.tell("continue")

    assert told.returncode == 0
    assert live.end() == 0
    assert [c["word"] for c in live.calls if c["word"] != "done"] == ["Broken", "ok"]


@TO_ONE
@pytest.mark.slow
def test_an_abort_of_a_run_that_an_error_has_paused_runs_finally(tmp_path, bench):
    live = Live(
        tmp_path, bench,
        "steps: [{fail: 'no argon', on_error: pause}]\n"
        "finally: [{do: b.act, with: {name: last}}]\n",
    )  # fmt: skip
    live.wait_for("control", "pause")
    live.process.send_signal(signal.SIGINT)

    assert live.end() == 130
    assert [c["name"] for c in live.calls if c["word"] == "done"] == ["last"]
    assert live.records[-1].fate == "aborted"


@pytest.mark.slow
def test_continue_after_an_error_in_a_loop_does_nothing_again_that_was_done(tmp_path, bench):
    live = Live(
        tmp_path, bench,
        """
steps:
  - foreach: {i: "${{ range(3) }}"}
    on_error: pause
    steps:
      - {id: shot, do: a.shoot, with: {name: "shot${{ i }}"}}
      - {do: b.act, with: {name: "b${{ i }}", script: "${{ 'Broken,ok' if i == 1 else 'ok' }}"}}
    collect: {shot: "${{ steps.shot.name }}"}
""",
    )  # fmt: skip
    live.wait_for("control", "pause")
    live.tell("continue")

    assert live.end() == 0
    done = [c["name"] for c in live.calls if c["word"] == "done"]
    assert sorted(done) == ["b0", "b1", "b2", "shot0", "shot1", "shot2"]
    (table,) = (tmp_path / "runs").glob("*/data.csv")
    assert table.read_text().splitlines()[1:] == [f"{i},shot{i},succeeded" for i in range(3)]


@pytest.mark.slow
def test_a_device_that_never_answers_runs_into_its_timeout_and_the_ladder(tmp_path, bench):
    live = Live(
        tmp_path, bench,
        """
steps:
  - do: a.act
    with: {name: x, script: hang}
    timeout: 0.3 s
    retry: {attempts: 2, on: [Timeout]}
    fallback: [{do: b.act, with: {name: instead}}]
""",
    )  # fmt: skip

    assert live.end() == 0
    assert [c["name"] for c in live.calls if c["word"] != "done"] == ["x", "x", "instead"]


def test_an_engine_that_is_there_and_silent_is_not_told_as_gone(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as mute:
        where = {"host": "127.0.0.1", "port": mute.getsockname()[1], "token": "t"}
        (tmp_path / "control.json").write_text(json.dumps(where))
        with pytest.raises(NotLive, match="is not running: no engine answers for it"):
            ask_run(tmp_path, {"verb": "abort"}, timeout_s=0.05)
        lock = FolderLock(tmp_path)
        lock.take()
        with pytest.raises(
            Silent, match=r"within 0\.05 s; its engine is there, and may still abort"
        ):
            ask_run(tmp_path, {"verb": "abort"}, timeout_s=0.05)
        lock.release()


@pytest.mark.soak
def test_a_run_whose_output_nobody_reads_goes_on_and_is_aborted(tmp_path, bench):
    live = Live(tmp_path, bench, LONG.replace("0.02", "0"))
    live.wait_for("goal", "succeeded")
    (journal,) = (tmp_path / "runs").glob("*/journal.jsonl")
    while len(journal.read_bytes()) < 120_000:  # its events are as long, and a pipe holds 64 kB
        time.sleep(0.05)

    assert live.tell("abort").returncode == 0
    assert live.end() == 1


@pytest.mark.slow
def test_telling_a_run_that_is_over_says_what_to_do(tmp_path, bench):
    live = Live(tmp_path, bench, "steps: [{do: a.act, with: {name: x}}]\n")
    live.end()

    told = live.tell("pause")

    assert told.returncode == 1
    assert "no engine answers" in told.stderr
