"""The paper's own names and types work as they are."""

import asyncio
import shutil
from pathlib import Path

import pytest

from labrun.engine.lab.lab import load_lab
from labrun.web.ros.interfaces.fault import RosFault
from labrun.web.ros.offers.offered_lab import Folders
from labrun.web.ros.open_lab import opened

from .served import command, serve

HERE = Path(__file__).parent
LAB = """
name: paper
simulated: true
devices:
  gantry:
    contract: gantry@1
    driver: sim_gantry
    config: {clock: fast, homed: true}
    limits: {x: {maximum: 500}}
  libs: {contract: libs_analyzer@1, driver: sim_libs, config: {clock: fast, gantry: gantry, core: 3, seed: 1}}
  reduce: {contract: spectrum_reducer@1, driver: reducer}
ros:
  aliases:
    /move_gantry: gantry
    /gantry_status: gantry
    /set_zero: gantry
    /take_measurement: libs
    /export_spectrum: libs
    /analyze_spectrum: reduce
    /arm/go: gantry.move_to
  launch: {greet: ./greet.yaml}
"""
PACKAGE = "custom_interfaces/action"


@pytest.fixture(scope="module")
def paper(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    (folder / "lab.yaml").write_text(LAB)
    shutil.copy(HERE.parents[2] / "protocols" / "hello.yaml", folder / "greet.yaml")
    (folder / "empty").mkdir()
    served = serve(folder, "--protocols", "empty", lab=folder / "lab.yaml")
    yield served

    assert served.end() == 0
    assert "Traceback" not in (folder / "ros.log").read_text()


def goal(name, type, **args):
    return {"do": "goal", "name": name, "type": f"{PACKAGE}/{type}", "args": args}


@pytest.mark.slow
def test_a_point_is_measured_as_the_papers_tree_does_it(talk, paper):
    up, over, down, shot, file, areas = talk(
        paper.url,
        goal("/move_gantry", "MoveGantry", cmd="G17 G21 G90 \n G00 Z10"),
        goal("/move_gantry", "MoveGantry", cmd="G17 G21 G90 \n G00 X2.5 Y3 \n"),
        goal("/move_gantry", "MoveGantry", cmd="G17 G21 G90 \n G00 Z0 \n"),
        goal("/take_measurement", "TakeMeasurement"),
        goal("/export_spectrum", "ExportSpectrum"),
        goal("/analyze_spectrum", "AnalyzeSpectrum"),
    )

    for told in (up, over, down, shot):
        assert told["values"] == {"msg": "success"}
    spectrum = Path(file["values"]["msg"])
    assert spectrum.read_text().startswith("wavelength,intensity")
    found = dict(zip(areas["values"]["peak_range"], areas["values"]["peak_area"], strict=True))
    assert {"Li", "K"} <= set(found)
    assert all(area >= 0 for area in found.values())


def test_the_zero_is_set_and_places_count_from_it(roslib1, paper):
    move = goal("/move_gantry", "MoveGantry", cmd="G90 G0 X100 Y50")
    status = {
        "do": "topic",
        "name": "/gantry_status",
        "type": "custom_interfaces/msg/GantryStatus",
        "count": 1,
    }
    zero = {
        "do": "service",
        "name": "/set_zero",
        "type": "customer_interfaces/SetZero",
        "args": {"axis": "x"},
    }
    back = {**zero, "args": {"axis": "xy"}}
    _, before, set_, after, moved, there, _, _ = roslib1(
        paper.url, move, {**status, "count": 2}, zero, status,
        goal("/move_gantry", "MoveGantry", cmd="G91 G0 X-10"),
        {"do": "topic", "name": "/gantry/status", "type": "labrun_interfaces/msg/GantryStatus", "count": 2},
        goal("/arm/go", "x", x=0, y=0), back,
    )  # fmt: skip

    assert before["messages"][-1] == {
        "work": "Idle",
        "x": 100,
        "y": 50,
        "z": before["messages"][-1]["z"],
    }
    assert set_["values"]["success"] is True
    assert after["messages"][0]["x"] == 0 and after["messages"][0]["y"] == 50
    assert moved["values"] == {"msg": "success"}
    assert there["messages"][-1]["x"] == 90


@pytest.mark.parametrize(
    ("cmd", "words"),
    [
        ("M3 S1000", "M3 is not a move"),
        ("G0 X600", "500"),
        ("G0 X1 X2", "X occurs twice"),
        ("", "it contains no move"),
        ("$X", "'$X' is not a word of G-code"),
        ("; rm -rf /", "it contains no move"),
    ],
)
def test_what_is_no_move_within_the_bench_is_refused_before_anything_moves(
    roslib2, paper, cmd, words
):
    (told,) = roslib2(
        paper.url, goal("/move_gantry", "MoveGantry", cmd=f"G0 Y1\n{cmd}" if "X600" in cmd else cmd)
    )

    assert words in told["error"]


def test_registered_protocols_are_launched_and_nothing_else(roslib1, paper):
    launch = {"do": "service", "name": "/launch", "type": "customer_interfaces/LaunchRequest"}
    asked = [
        {"cmd": "cli", "package": "ros2 action", "file_name": "/move_gantry", "args": "; touch pwned"},
        {"cmd": "launch", "package": "", "file_name": "../greet.yaml", "args": ""},
        {"cmd": "launch", "package": "x", "file_name": "greet", "args": '{"there": "25 mm"}'},
        {"cmd": "kill", "package": "x", "file_name": "greet", "args": ""},
    ]  # fmt: skip
    cli, path, good, stop = roslib1(paper.url, *({**launch, "args": args} for args in asked))

    assert "no command line is run" in cli["error"]
    assert "is not registered" in path["error"]
    assert good["values"] == {
        "file_name": "greet",
        "message": "greet is launched",
        "is_launched": True,
    }
    assert stop["values"]["message"] == "greet is being aborted"
    assert not list(paper.folder.glob("**/pwned*"))


def aliased(folder, aliases):
    (folder / "lab.yaml").write_text(LAB.partition("ros:")[0] + f"ros: {{aliases: {aliases}}}\n")


@pytest.mark.slow
def test_an_alias_that_cannot_be_is_a_sentence_and_status_2(tmp_path):
    aliased(tmp_path, "{/move_gantry: libs}")
    done = command(tmp_path, "--lab", "lab.yaml", "--port", "0")

    assert done.returncode == 2
    assert "/move_gantry needs a gantry@1, and libs is a libs_analyzer@1" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("aliases", "words"),
    [
        ("{/move_gantry: gantri}", "there is no device gantri; did you mean gantry?"),
        ("{move__gantry: gantry}", "is not a valid ROS name"),
        ("{/gantry/home: gantry.home}", "is already in use"),
        ("{/arm: gantry.fly}", "is not a `device.action` of this lab"),
    ],
)
def test_an_alias_that_cannot_be_is_refused_before_any_device_starts(tmp_path, aliases, words):
    aliased(tmp_path, aliases)
    lab, _ = load_lab(tmp_path / "lab.yaml")
    folders = Folders(*(tmp_path / name for name in ("protocols", "runs", "files", "state")))

    async def main():
        async with opened(lab, "labrun_interfaces", folders):
            pass

    with pytest.raises(RosFault) as refused:
        asyncio.run(main())

    assert words in str(refused.value)
    assert not (tmp_path / "state" / "servers").exists()
