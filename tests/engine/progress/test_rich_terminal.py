"""What a person at a terminal sees, and how the keyboard answers: on a real pseudo-terminal."""

import os
import pty
import signal
import subprocess
import sys
import time

import pytest

HEADER = "labrun: 1\nname: seen\ndevices: {a: scripted@1, b: scripted@1}\n"


class Terminal:
    """A labrun process on its own pseudo-terminal."""

    def __init__(self, folder, lab, body):
        (folder / "seen.yaml").write_text(HEADER + body)
        self.ours, theirs = pty.openpty()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "labrun.engine", "run", "seen.yaml", "--lab", str(lab)],
            cwd=folder, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
            env={**os.environ, "TERM": "xterm-256color", "COLUMNS": "100"},
        )  # fmt: skip
        os.close(theirs)
        self.screen = ""

    def wait_for(self, text, timeout_s=500):
        until = time.monotonic() + timeout_s
        while text not in self.screen and time.monotonic() < until:
            try:
                self.screen += os.read(self.ours, 65536).decode(errors="replace")
            except OSError:  # the other side has closed
                break
        assert text in self.screen, self.screen

    def type(self, text):
        os.write(self.ours, text.encode())

    def end(self):
        status = self.process.wait()
        os.close(self.ours)
        return status


def test_a_question_is_answered_at_the_keyboard_and_the_run_goes_on(tmp_path, bench):
    terminal = Terminal(
        tmp_path, bench.lab,
        "steps:\n  - {id: sure, confirm: 'All [/red] closed?'}\n  - {do: a.act, with: {name: x}}\n",
    )  # fmt: skip
    terminal.wait_for("All [/red] closed? [yes/no] ")

    terminal.type("perhaps\n")
    terminal.wait_for("choose yes, no")
    terminal.type("y\n")

    terminal.wait_for("run succeeded")
    assert terminal.end() == 0


@pytest.mark.slow
def test_points_rate_and_time_left_are_shown_while_a_loop_runs(tmp_path, bench):
    terminal = Terminal(
        tmp_path, bench.lab,
        "steps:\n  - id: scan\n    foreach: {i: '${{ range(40) }}'}\n"
        "    steps: [{do: a.act, with: {name: x, seconds: 0.03}}]\n",
    )  # fmt: skip

    terminal.wait_for("/40")
    terminal.wait_for("left")
    terminal.wait_for("a.act")

    terminal.wait_for("run succeeded")
    assert terminal.end() == 0


def test_ctrl_c_at_the_keyboard_aborts_and_says_how_to_go_on(tmp_path, bench):
    terminal = Terminal(
        tmp_path, bench.lab,
        "steps: [{do: a.act, with: {name: x, seconds: 60}}]\n"
        "finally: [{do: b.act, with: {name: last}}]\n",
    )  # fmt: skip
    terminal.wait_for("a.act")

    terminal.process.send_signal(signal.SIGINT)

    terminal.wait_for("run aborted")
    terminal.wait_for("labrun resume")
    assert terminal.end() == 130
