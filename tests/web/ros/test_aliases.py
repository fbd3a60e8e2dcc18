"""The paper's own names and types work as they are."""

import asyncio
import contextlib
import json
import shutil
import time
from pathlib import Path

import pytest

from labrun.engine.lab.lab import load_lab
from labrun.engine.run.virtual_time import VirtualLoop
from labrun.web.ros.aliases.paper import Paper
from labrun.web.ros.aliases.set_zero import SetZero
from labrun.web.ros.interfaces.fault import RosFault
from labrun.web.ros.offers.offer import Refused
from labrun.web.ros.offers.offered_lab import Folders, OfferedLab
from labrun.web.ros.open_lab import opened

from .served import command, serve

HERE = Path(__file__).parent
LAB = """
name: paper
simulated: true
start_timeout: 500 s
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
    /is_gantry_rdy: gantry
    /is_analytical_dev_rdy: libs
    /z300_status: libs
    /arm/go: gantry.move_to
  action_timeout: 500 s
  launch: {greet: ./greet.yaml, single_sample_mapping: ./grid.yaml}
"""
CAMERA = """
name: paper
simulated: true
start_timeout: 500 s
devices:
  gantry: {contract: gantry@1, driver: sim_gantry, config: {clock: fast, homed: true}}
  camera:
    contract: depth_camera@1
    driver: sim_depth_camera
    config:
      clock: fast
      core: 3
      place: {x: 200, y: -200, z: 620, tilt: 33}
      board: {columns: 9, rows: 6, square: 25, x: 100, y: 300}
      stones: [[350, 400, 60, 40, 25], [400, 300, 30, 30, 12]]
ros: {aliases: {/move_gantry: gantry, /detect_samples: camera}, action_timeout: 500 s}
"""
GRID = """
labrun: 1
name: grid
params:
  x_gap: {type: quantity, unit: mm, default: 0.2 mm, minimum: 0.01 mm}
  y_gap: {type: quantity, unit: mm, default: 0.2 mm, minimum: 0.01 mm}
  x_points: {type: integer, default: 51, minimum: 1}
  y_points: {type: integer, default: 51, minimum: 1}
devices: {gantry: gantry@1, libs: libs_analyzer@1}
steps:
  - foreach: {x: "${{ range(params.x_points) }}"}
    key: ${{ x }}
    steps:
      - {do: gantry.move_to, with: {x: "${{ x * params.x_gap }}"}}
      - {wait: 2 s}
finally:
  - {do: libs.disarm}
  - {wait: 2 s}
outputs: {gap: "${{ params.x_gap }}", points: "${{ params.x_points }}"}
"""
PACKAGE = "custom_interfaces/action"


@pytest.fixture(scope="module")
def paper(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    (folder / "lab.yaml").write_text(LAB)
    shutil.copy(HERE.parents[2] / "protocols" / "hello.yaml", folder / "greet.yaml")
    (folder / "grid.yaml").write_text(GRID)
    (folder / "empty").mkdir()
    served = serve(folder, "--no-token", "--protocols", "empty", lab=folder / "lab.yaml")
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

    for told in (up, over, down):
        assert told["values"] == {"msg": "success"}
    assert shot["values"] == file["values"] == {}  # the paper's types have no field here
    spectrum = Path(file["feedback"][-1]["feedback"])
    assert spectrum.read_text().startswith("wavelength,intensity")
    assert {*areas["values"]} == {"peak_range", "peak_area"}
    found = dict(zip(areas["values"]["peak_range"], areas["values"]["peak_area"], strict=True))
    assert {"Li", "K"} <= set(found)
    assert all(area >= 0 for area in found.values())


@pytest.mark.soak
def test_samples_are_detected_as_the_papers_newer_tree_asks_and_keep_their_ids(roslibpy, tmp_path):
    (tmp_path / "lab.yaml").write_text(CAMERA)
    served = serve(tmp_path, "--no-token", lab=tmp_path / "lab.yaml")
    calibrate = {"x": 100, "y": 300, "columns": 9, "rows": 6, "square": 25}
    early, _, once, again = roslibpy(
        served.url,
        goal("/detect_samples", "DetectSamples"),
        {"do": "goal", "name": "/camera/calibrate", "args": calibrate,
         "type": "labrun_interfaces/action/DepthCameraCalibrate"},
        goal("/detect_samples", "DetectSamples"),
        goal("/detect_samples", "DetectSamples"),
    )  # fmt: skip

    assert served.end() == 0
    assert "NotCalibrated" in early["feedback"][-1]["feedback"]
    assert [sorted(told["values"]["ids"]) for told in (once, again)] == [[1, 2, 3], [1, 2, 3]]
    found = [(loc["x_g"], loc["y_g"], loc["z_g"]) for loc in once["values"]["gantry_locs"]]
    nearest = min(found, key=lambda place: abs(place[0] - 0.38))
    assert nearest[:2] == pytest.approx((0.38, 0.42), abs=0.01)
    assert nearest[2] == pytest.approx(0.025, abs=0.005)


@pytest.mark.slow
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
    _, set_, after, moved, _, there, _, _, again = roslib1(
        paper.url, move, zero, status,
        goal("/move_gantry", "MoveGantry", cmd="G91 G0 X-10"),
        goal("/move_gantry", "MoveGantry", cmd="G91 G0 X-10"),  # from where the last has ended
        {"do": "topic", "name": "/gantry/status", "type": "labrun_interfaces/msg/GantryStatus",
         "count": 1, "until": {"x": 80}},
        goal("/arm/go", "x", x=0, y=0), back, status,
    )  # fmt: skip

    assert set_ == {"values": {}}  # of the place after the move, however late a status is told
    told = after["messages"][0]
    assert told == {"work": "Idle", "x": 0, "y": 50, "z": told["z"]}
    assert moved["values"] == {"msg": "success"}
    assert there["messages"][-1]["x"] == 80
    assert (again["messages"][0]["x"], again["messages"][0]["y"]) == (0, 0)


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


def asked(*requests):
    launch = {"do": "service", "name": "/launch", "type": "customer_interfaces/LaunchRequest"}
    return [{**launch, "args": request} for request in requests]


def page(cmd, file_name="single_sample_mapping", package="bt", **args):
    """A request as the paper's page makes it; `kill` has no args."""
    return {"cmd": cmd, "package": package, "file_name": file_name, **args}


def test_registered_protocols_are_launched_and_nothing_else(roslib1, paper):
    cli, path, good, stop, unknown = roslib1(paper.url, *asked(
        page("cli", "/move_gantry", "ros2 action", args="; touch pwned"),
        page("launch", "../greet.yaml", args=""),
        page("launch", "greet", args='{"there": "25 mm"}'),
        page("kill", "greet"), page("kill", "multipleSamples"),
    ))  # fmt: skip

    assert "no command line is run" in cli["values"]["message"]
    assert "failed to launch: '../greet.yaml' is not registered" in path["values"]["message"]
    assert [one["values"]["is_launched"] for one in (cli, path)] == [False, False]
    assert good["values"] == {
        "file_name": "greet", "message": "bt greet was launched successfully.", "is_launched": True,
    }  # fmt: skip
    assert stop["values"]["message"] == "bt greet is being stopped."
    assert unknown["values"]["message"] == "bt multipleSamples has not been launched yet."
    assert not list(paper.folder.glob("**/pwned*"))


def stopped(talk, paper, name):
    """Stop it, and wait until it has ended, so that the devices are free for the next test."""
    told = ""
    while "has not been launched yet" not in told:
        (answer,) = talk(paper.url, *asked(page("kill", name)))
        told = answer["values"]["message"]
        time.sleep(0.2)


GAPS = "--ros-args -p x_gap:=0.2 -p y_gap:=1.0 -p x_points:=3 -p y_points:=4"


@pytest.mark.slow
def test_the_papers_page_starts_and_stops_a_map_by_its_own_words(roslib1, paper):
    start, again, kill, during = roslib1(
        paper.url,
        *asked(
            page("run", args=GAPS), page("run", args=GAPS), page("kill"), page("run", args=GAPS)
        ),
    )
    while "still being stopped" in during["values"]["message"]:
        time.sleep(0.5)
        (during,) = roslib1(paper.url, *asked(page("run", args=GAPS)))
    # The answer comes once the run is accepted; its folder is made by the process that runs it.
    while not (begun := sorted((paper.folder / "runs").glob("*grid*/run.json"))):
        time.sleep(0.1)
    stopped(roslib1, paper, "single_sample_mapping")
    options = json.loads(begun[-1].read_text())

    assert start["values"] == {
        "message": "bt single_sample_mapping was launched successfully.", "is_launched": True,
        "file_name": "single_sample_mapping",
    }  # fmt: skip
    assert again["values"]["message"] == "bt single_sample_mapping has already been launched."
    assert again["values"]["is_launched"] is True
    assert kill["values"]["is_launched"] is False
    assert during["values"]["message"] == "bt single_sample_mapping was launched successfully."
    assert options["params"] == {
        "x_gap": "0.2", "y_gap": "1.0", "x_points": "3", "y_points": "4",
    }  # fmt: skip


@pytest.mark.slow
def test_while_a_map_is_being_stopped_it_is_not_said_to_be_launched(roslib1, paper):
    _, kill, during = roslib1(
        paper.url,
        *asked(page("run", "greet", args=""), page("kill", "greet"), page("run", "greet")),
    )

    assert kill["values"]["is_launched"] is False
    assert during["values"]["is_launched"] is False
    assert "it is still being stopped" in during["values"]["message"]
    stopped(roslib1, paper, "greet")


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ("--ros-args -p", "after --ros-args come `-p NAME:=VALUE`"),  # of its multiple samples
        ("--ros-args -p x_gap:=0.2.0", "x_gap: '0.2.0' is not a number"),  # 0.2 and then '.0'
        ("--ros-args -p x_points:=NaN", "x_points"),  # an empty field
        ("--ros-args -p speed:=3", "speed"),
        ("--ros-args -r a:=b", "not '-r'"),
        ("; touch pwned", "does not begin with --ros-args"),
        ('--ros-args -p "x_gap:=1', "No closing quotation"),
    ],
)
def test_what_the_papers_launcher_would_fail_on_is_answered_not_launched(
    roslib1, paper, args, words
):
    (told,) = roslib1(paper.url, *asked(page("run", args=args)))

    assert told["values"]["is_launched"] is False
    assert "bt single_sample_mapping failed to launch: " in told["values"]["message"]
    assert words in told["values"]["message"]


def test_readiness_is_a_service_and_a_topic_as_in_the_paper(roslib1, paper):
    ready = {"do": "service", "type": "custom_interfaces/IsRdy", "args": {}}
    gantry, libs, status, moved = roslib1(
        paper.url,
        {**ready, "name": "/is_gantry_rdy"}, {**ready, "name": "/is_analytical_dev_rdy"},
        {"do": "topic", "name": "/z300_status", "type": "std_msgs/String", "count": 2},
        {"do": "service", "name": "/move_gantry", "type": "custom_interfaces/MoveGantry",
         "args": {"cmd": "G0 X3"}},
    )  # fmt: skip

    assert gantry["values"] == libs["values"] == {"ready": True}
    assert [one["data"] for one in status["messages"]] == ["IDLE", "IDLE"]
    assert moved["values"] == {"response": "succeed"}


@pytest.fixture
def offered(tmp_path):
    (tmp_path / "lab.yaml").write_text(LAB)
    folders = Folders(tmp_path, tmp_path, tmp_path, tmp_path)
    return OfferedLab(load_lab(tmp_path / "lab.yaml")[0], "labrun_interfaces", "ros", folders)


def test_topics_come_twice_a_second_while_nothing_changes(offered):
    told = []

    async def story():
        paper = Paper(offered)
        paper.tells(lambda: told.append(asyncio.get_running_loop().time()))
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(paper.tell_often(), 3.2)

    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        runner.run(story())

    assert told == pytest.approx([0.5, 1, 1.5, 2, 2.5, 3])


@pytest.mark.parametrize(
    ("states", "said"),
    [
        (["moving", "idle"], None),  # the first was asked for before the move had ended
        (["idle", "moving"], "gantry is moving; set the zero when it has stopped"),
        (["idle"], "gantry did not report its status within 500 s"),
    ],
)
def test_a_zero_is_set_from_a_status_that_was_asked_for_after_the_call(offered, states, said):
    async def story():
        paper = Paper(offered)
        offered.hear("gantry", {"state": "idle", "x": 1.0})
        answer = asyncio.ensure_future(SetZero(paper, "/set_zero", "gantry").answer({"axis": "x"}))
        for n, state in enumerate(states):
            await asyncio.sleep(1)
            offered.hear("gantry", {"state": state, "x": 10.0 * (n + 1)})
        try:
            return await answer, paper.zero("gantry")["x"]
        except Refused as refused:
            return str(refused), paper.zero("gantry")["x"]

    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        assert runner.run(story()) == (({}, 20.0) if said is None else (said, 0.0))


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
