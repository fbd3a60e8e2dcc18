"""What a person at a terminal sees, and how the keyboard answers: on a real pseudo-terminal."""

import signal

import pytest

HEADER = "labrun: 1\nname: seen\ndevices: {a: scripted@1, b: scripted@1}\n"


@pytest.fixture
def run(terminal, tmp_path, bench):
    """`run(body)`: a protocol with this body, at a terminal."""

    def start(body):
        (tmp_path / "seen.yaml").write_text(HEADER + body)
        return terminal("run", "seen.yaml", "--lab", bench.lab, COLUMNS="100")

    return start


def test_a_question_is_answered_at_the_keyboard_and_the_run_goes_on(run):
    terminal = run(
        "steps:\n  - {id: sure, confirm: 'All [/red] closed?'}\n  - {do: a.act, with: {name: x}}\n",
    )  # fmt: skip
    terminal.wait_for("All [/red] closed? [yes/no] ")

    terminal.press("perhaps\n")
    terminal.wait_for("choose yes, no")
    terminal.press("y\n")

    terminal.wait_for("run succeeded")
    assert terminal.end() == 0


@pytest.mark.slow
def test_points_rate_and_time_left_are_shown_while_a_loop_runs(run):
    terminal = run(
        "steps:\n  - id: scan\n    foreach: {i: '${{ range(40) }}'}\n"
        "    steps: [{do: a.act, with: {name: x, seconds: 0.03}}]\n",
    )  # fmt: skip

    terminal.wait_for("/40")
    terminal.wait_for("left")
    terminal.wait_for("a.act")

    terminal.wait_for("run succeeded")
    assert terminal.end() == 0


def test_ctrl_c_at_the_keyboard_aborts_and_says_how_to_go_on(run):
    terminal = run(
        "steps: [{do: a.act, with: {name: x, seconds: 60}}]\n"
        "finally: [{do: b.act, with: {name: last}}]\n",
    )  # fmt: skip
    terminal.wait_for("a.act")

    terminal.process.send_signal(signal.SIGINT)

    terminal.wait_for("run aborted")
    terminal.wait_for("labrun resume")
    assert terminal.end() == 130
