"""The command line as a whole: bare files, exit statuses, and never a traceback."""

import errno
import json
import os
import subprocess
import sys
from importlib.metadata import entry_points

import pytest

from labrun import __version__
from labrun.engine import cli
from labrun.engine.cli import COMMANDS, FROM_ENTRY_POINTS, GROUPS, arguments, ros_args

from ..command_line import labrun as in_process

COMMAND = [sys.executable, "-m", "labrun.engine"]


def labrun(folder, *words):
    return subprocess.run([*COMMAND, *words], cwd=folder, capture_output=True, text=True)


def test_a_bare_file_is_run(tmp_path):
    assert arguments(["x.yaml", "--yes"], {"run"}) == ["run", "x.yaml", "--yes"]
    assert arguments(["check", "x.yaml"], {"run", "check"}) == ["check", "x.yaml"]
    assert arguments(["--help"], {"run"}) == ["--help"]


def test_help_shows_every_command_in_its_group(tmp_path):
    shown = labrun(tmp_path, "--help").stdout
    installed = {point.name for point in entry_points(group="labrun.commands")}

    assert {name for names in GROUPS.values() for name in names} == installed | set(COMMANDS)
    assert installed == FROM_ENTRY_POINTS
    for group, names in GROUPS.items():
        panel = shown.partition(f" {group} ")[2].partition("╰")[0]
        assert [name for name in names if f"│ {name} " not in panel] == []


def test_commands_are_completed_in_the_shell(tmp_path):
    completed = subprocess.run(
        COMMAND, cwd=tmp_path, capture_output=True, text=True,
        env={
            **os.environ, "_LABRUN_COMPLETE": "complete_bash", "COMP_WORDS": "labrun re",
            "COMP_CWORD": "1",
        },
    )  # fmt: skip

    assert {"rehearse", "resume", "report", "reduce"} <= set(completed.stdout.split())


def test_version(tmp_path):
    assert labrun(tmp_path, "--version").stdout == f"labrun {__version__}\n"


@pytest.mark.parametrize(
    ("words", "status", "says"),
    [
        (["nope.yaml"], 2, "this folder has no .yaml file; `labrun new nope` writes a protocol"),
        (["."], 2, "folder"),
        (["chekc", "x"], 2, "Did you mean 'check'"),
        (["run", "x.yaml", "-p", "pitch"], 2, "NAME=VALUE"),
        (["runs", "--runs", "nothing"], 0, "no runs"),
        (["abort", "nope"], 2, "no run 'nope'"),
        (["devices", "gantri"], 2, "no device 'gantri'"),
        (["call", "gantry.fly"], 2, "no action 'fly'"),
        (["call", "gantry.move_to", "x=10 s", "--yes"], 2, "is a time"),
        (["call", "gantry.move_to", "x=9 m", "--yes"], 2, "730"),
        (["call", "gantry.home"], 2, "dangerous"),
        (["serve", "nothing"], 2, "no device 'nothing'"),
        (["report", "nope"], 2, "no run"),
        (["status", "nope"], 2, "no device 'nope'"),
        (["status", "nope"], 2, "`labrun runs` lists the runs"),
    ],
)
def test_what_a_person_gets_wrong_is_one_clear_message(tmp_path, words, status, says):
    told = in_process(tmp_path, *words)

    assert told.returncode == status, told.stdout + told.stderr
    assert says in told.stdout + told.stderr
    assert "Traceback" not in told.stderr


def test_a_server_that_is_down_is_status_4_with_device_and_address_and_no_run_is_left(tmp_path):
    (tmp_path / "lab.yaml").write_text(
        "name: l\ndevices: {g: {contract: gantry@1, url: 'http://127.0.0.1:9'}}\n"
    )
    (tmp_path / "p.yaml").write_text(
        "labrun: 1\nname: p\ndevices: {g: gantry@1}\nsteps: [{do: g.home}]\n"
    )

    told = labrun(tmp_path, "p.yaml", "--lab", "lab.yaml")

    assert told.returncode == 4
    assert "'g'" in told.stderr
    assert "http://127.0.0.1:9" in told.stderr
    assert list((tmp_path / "runs").iterdir()) == []


def test_json_tells_events_line_by_line(tmp_path):
    (tmp_path / "p.yaml").write_text("labrun: 1\nname: p\nsteps: [{log: hello}]\n")

    told = labrun(tmp_path, "p.yaml", "--json")

    events = [json.loads(line) for line in told.stdout.splitlines()]
    assert told.returncode == 0
    assert [e["text"] for e in events if e["event"] == "log"] == ["hello"]
    assert events[-1]["event"] == "finished"
    assert events[-1]["state"] == "succeeded"


def test_runs_lists_what_was_run_and_how_it_ended(tmp_path):
    (tmp_path / "p.yaml").write_text("labrun: 1\nname: p\nsteps: [{fail: on purpose}]\n")
    labrun(tmp_path, "p.yaml")

    (row,) = json.loads(labrun(tmp_path, "runs", "--json").stdout)

    assert row["fate"] == "failed"
    assert "on purpose" in row["reason"]
    assert in_process(tmp_path, "status", "last").stdout == in_process(tmp_path, "runs").stdout


def test_a_folder_for_runs_that_cannot_be_made_is_a_sentence(tmp_path):
    (tmp_path / "p.yaml").write_text("labrun: 1\nname: p\nsteps: [{log: hello}]\n")
    (tmp_path / "file").write_text("")

    told = labrun(tmp_path, "p.yaml", "--runs", "file/runs")

    assert told.returncode == 1
    assert "cannot create a run folder" in told.stderr


@pytest.mark.parametrize(
    ("given", "read"),
    [
        (["ros", "--ros-args", "-r", "__ns:=/b 1"], ["ros", "--ros-args=-r '__ns:=/b 1'"]),
        (["ros", "--ros-args", "-p", "a:=1", "--", "--node"], ["ros", "--ros-args=-p a:=1", "--node"]),
        (["ros", "--node"], ["ros", "--node"]),
        (["run", "--ros-args", "x"], ["run", "--ros-args", "x"]),
    ],
)  # fmt: skip
def test_arguments_as_ros_launches_its_programs_are_one_option(given, read):
    assert ros_args(given) == read


@pytest.mark.parametrize(
    ("words", "status"),
    [(["devices"], 0), (["check", "good.yaml"], 0), (["check", "bad.yaml"], 2)],
)
def test_a_reader_who_leaves_changes_no_exit_status(tmp_path, monkeypatch, words, status):
    good = "labrun: 1\nname: good\nsteps: [{wait: 1 s}]\n"
    (tmp_path / "good.yaml").write_text(good, encoding="utf-8")
    (tmp_path / "bad.yaml").write_text(good + "stepz: []\n", encoding="utf-8")
    reads, writes = os.pipe()
    os.close(reads)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(os, "_exit", sys.exit)
    monkeypatch.setattr("gc.freeze", lambda: None)
    with os.fdopen(writes, "w", encoding="utf-8") as nobody:
        monkeypatch.setattr(sys, "stdout", nobody)
        ended = cli._status(words, {})
        monkeypatch.undo()

    assert ended == status


@pytest.mark.parametrize(
    ("fault", "status", "says"),
    [
        (OSError(errno.EROFS, "Read-only file system", "runs/x"), 2, "labrun: runs/x: Read-only"),
        (PermissionError(errno.EACCES, "Permission denied"), 0, ""),  # of a port, say
        (FileNotFoundError(errno.ENOENT, "No such file", "x"), 0, ""),
        (ValueError("x"), 0, ""),
    ],
)
def test_what_a_disk_refuses_is_no_internal_error(fault, status, says, capsys):
    assert cli._of_the_disk(fault) == status
    assert capsys.readouterr().err.startswith(says)
