"""`labrun ros --node` with a real ROS 2: its action clients, its types, its discovery."""

import json
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, contextmanager, suppress
from hashlib import sha256
from pathlib import Path

import pytest

from . import make_ros

pytestmark = [pytest.mark.soak, pytest.mark.timeout(1800)]
HERE = Path(__file__).parent
LAB = """
name: ros
simulated: true
start_timeout: 500 s
contracts: [./lamp.yaml]
devices:
  gantry: {contract: gantry@1, driver: sim_gantry, config: {clock: fast, homed: true}}
  Lamp__9_: {contract: lamp@1, driver: "./lamp.py:Lamp"}
ros: {aliases: {/move_gantry: gantry}, action_timeout: 500 s}
"""
PROTOCOL = """
labrun: 1
name: glowing
params: {there: {type: quantity, unit: mm, default: 20 mm}}
devices: {gantry: gantry@1, lamp: lamp@1}
steps:
  - {id: travel, do: gantry.move_to, with: {x: "${{ params.there }}"}}
  - {do: lamp.glow, with: {seconds: 0.2 s}}
outputs: {x: "${{ steps.travel.x }}"}
"""
RUNS_HERE = sys.platform == "linux" and platform.machine() == "x86_64"
LIBC = platform.libc_ver()


def kept(kind, *texts):
    """A folder that outlives the session: what is in it costs minutes to make."""
    digest = sha256("".join([sys.version, *texts]).encode()).hexdigest()[:12]
    return Path(tempfile.gettempdir()) / f"labrun-ros-{kind}-{digest}"


def made(folder, make, *, anew=False):
    with locked(folder.name, wait=True):  # of several workers one makes it, and the others wait
        if not (folder / "complete").exists():
            if anew:  # half of an environment is none; half of a build goes on
                shutil.rmtree(folder, ignore_errors=True)
            folder.parent.mkdir(parents=True, exist_ok=True)
            make(folder)
            (folder / "complete").touch()
    return folder


@contextmanager
def locked(name, *, wait):
    """Held by one process of this machine at a time; raises BlockingIOError where it may not wait."""
    import fcntl

    with (Path(tempfile.gettempdir()) / f"{name}.lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        yield


@pytest.fixture(scope="session")
def domain():
    """A domain of ROS that no other session on this machine is in."""
    with ExitStack() as kept_locks:
        for number in range(1, 101):
            with suppress(BlockingIOError):
                kept_locks.enter_context(locked(f"labrun-ros-domain-{number}", wait=False))
                yield str(number)
                return
        pytest.fail("a hundred domains of ROS are in use")


@pytest.fixture(scope="session")
def ros():
    if not RUNS_HERE or LIBC[0] != "glibc":
        pytest.skip(
            f"the wheels of ROS 2 are for x86-64 Linux with glibc, this is {platform.platform()}"
        )
    return made(
        kept("wheels", Path(make_ros.__file__).read_text(), sys.prefix), make_ros.make, anew=True
    )


@pytest.fixture(scope="session")
def ros_lab(lab):
    path = lab.with_name("ros.yaml")
    path.write_text(LAB)
    return path


@pytest.fixture(scope="session")
def interfaces(ros, ros_lab, tmp_path_factory):
    """The lab's interfaces, generated, built by CMake as colcon does it, and installed."""
    source = tmp_path_factory.mktemp("interfaces")
    command = [
        sys.executable,
        "-P",
        "-m",
        "labrun.engine",
        "ros",
        "--lab",
        str(ros_lab),
        "--interfaces",
        str(source),
    ]
    subprocess.run(command, check=True, capture_output=True, cwd=source)
    texts = [path.read_text() for path in sorted(source.rglob("*")) if path.is_file()]

    def build(folder):
        there = folder / "src"  # CMake goes on with half of a build from the same place alone
        if not there.exists():
            shutil.copytree(source, there)
        for package in sorted(there.iterdir()):
            make_ros.build(ros, package, folder / package.name)

    return made(kept("interfaces", *texts), build)


@pytest.fixture(scope="session")
def environment(ros, interfaces, domain):
    prefixes = [path for path in sorted(interfaces.iterdir()) if (path / "share").is_dir()]
    return {
        **make_ros.clean_environment(ros, *prefixes),
        "ROS_DOMAIN_ID": domain,
        "PYTHONUNBUFFERED": "1",
    }


@pytest.fixture
def node(ros, ros_lab, environment, tmp_path):
    """The node, in a folder of its own."""
    command = [
        str(ros / "bin" / "python"),
        "-P",
        "-m",
        "labrun.engine",
        "ros",
        "--node",
        "--lab",
        str(ros_lab),
    ]
    (tmp_path / "glowing.yaml").write_text(PROTOCOL)
    log = tmp_path / "node.log"
    with log.open("wb") as sink:
        process = subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=sink, stderr=sink)
    until = time.monotonic() + 120
    while b"Ctrl-C" not in log.read_bytes():
        assert process.poll() is None and time.monotonic() < until, log.read_text()
        time.sleep(0.1)
    yield tmp_path
    process.send_signal(signal.SIGINT)

    assert process.wait() == 0
    assert "Traceback" not in log.read_text(), log.read_text()


@pytest.fixture
def ask(ros, environment):
    def client(name, **more):
        done = subprocess.run(
            [str(ros / "bin" / "python"), str(HERE / "client.py"), name], env={**environment, **more},
            capture_output=True, text=True,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout.splitlines()[-1])

    return client


def test_goals_succeed_fail_and_are_rejected_by_the_contract(node, ask):
    assert ask("goals") == {
        "accepted": True, "status": 4, "pattern": [1, 2], "feedback": ["glowing warm white", "done"],
        "rejected": [False] * 4, "burnt": [6, "Burnt", "yes"],
    }  # fmt: skip


def test_forty_goals_are_cancelled_and_what_cannot_be_is_not(node, ask):
    assert ask("cancels") == {"seen": [[1, 5]], "count": 40, "beacon": 0}


def test_status_is_a_topic_and_a_pure_action_a_service(node, ask):
    assert ask("reads") == {
        "hours": [12.5], "error": "Unknown", "colour": "warm white", "levels": [1.5, 2.25], "x": 3.5,
    }  # fmt: skip


def test_a_goal_is_aborted_when_its_device_server_is_killed(node, ask):
    server = json.loads((node / ".labrun/ros/servers/Lamp__9_/server.json").read_text())

    assert ask("lost", LAMP_PID=str(server["pid"])) == {"status": 6, "error": "Lost"}


def test_a_protocol_runs_as_an_action(node, ask):
    told = ask("protocol")

    assert (told["status"], told["fate"], told["bad"]) == (4, "succeeded", False)
    assert told["outputs"]["x"] == {"$quantity": [30.0, "mm"]}
    assert (node / "runs" / told["run"] / "report.html").is_file()


def test_a_behaviour_tree_of_ros_ticks_succeeds_fails_and_is_interrupted(node, ask):
    """As an action client of py_trees_ros does it: callbacks from a spinning node, ticks beside."""
    assert ask("tree") == {
        "good": "SUCCESS", "burnt": "FAILURE", "rejected": "FAILURE",
        "interrupted": "INVALID", "canceled": 5,
    }  # fmt: skip


def test_what_the_command_line_of_ros_asks_for_is_there(node, ask):
    """`ros2 action list -t`, `ros2 topic info -v`, `ros2 node info` ask the graph for this."""
    told = ask("graph")

    assert told["actions"]["/Lamp_9/glow"] == ["labrun_interfaces/action/LampGlow"]
    assert told["actions"]["/labrun/run_protocol"] == ["labrun_interfaces/action/RunProtocol"]
    assert told["actions"]["/move_gantry"] == ["custom_interfaces/action/MoveGantry"]
    assert told["topics"]["/Lamp_9/status"] == ["labrun_interfaces/msg/LampStatus"]
    assert told["services"]["/Lamp_9/age"] == ["labrun_interfaces/srv/LampAge"]
    assert told["node"] == "labrun" and told["qos"] == ["RELIABLE", "TRANSIENT_LOCAL"]


def test_the_papers_types_work_as_they_are(node, ask):
    assert ask("paper") == {"status": 4, "msg": "success", "bad": False}


def test_interfaces_of_another_lab_are_named_and_nothing_starts(ros, environment, lab, tmp_path):
    shutil.copy(lab.with_name("lamp.py"), tmp_path)
    other = (
        lab.with_name("lamp.yaml")
        .read_text()
        .replace("seconds: {type: number", "seconds: {type: integer")
    )
    (tmp_path / "lamp.yaml").write_text(other)
    (tmp_path / "lab.yaml").write_text(LAB)
    done = subprocess.run(
        [str(ros / "bin" / "python"), "-P", "-m", "labrun.engine", "ros", "--node", "--lab", "lab.yaml"],
        cwd=tmp_path, env=environment, capture_output=True, text=True,
    )  # fmt: skip

    assert done.returncode == 2
    assert (
        "LampGlow is built from another contract" in done.stderr and "Traceback" not in done.stderr
    )


def test_a_robot_of_ros_is_a_device_of_the_lab_by_rclpy(
    node, ros, environment, lab, tmp_path_factory
):
    """The other way round: labrun as a client of a ROS action server."""
    folder = tmp_path_factory.mktemp("client")
    actions = {
        name: {
            "action": f"/Lamp_9/{name}",
            "type": f"labrun_interfaces/action/Lamp{name.capitalize()}",
        }
        for name in ("glow", "flash", "age", "beacon")
    }
    optional = {name: {"field": name, "optional": True} for name in ("hours", "of")}
    actions["glow"]["goal"] = {"pattern": "pattern"}
    actions["age"]["result"] = {"hours": optional["hours"]}
    actions["age"]["goal"] = {"of": optional["of"]}
    config = json.dumps({"node": True, "actions": actions})
    (folder / "lab.yaml").write_text(
        f"name: client\ncontracts: [{lab.with_name('lamp.yaml')}]\n"
        f"devices:\n  far: {{contract: lamp@1, driver: ros_action, config: {config}}}\n"
    )

    def call(*words):
        return subprocess.run(
            [str(ros / "bin" / "python"), "-P", "-m", "labrun.engine", "call", *words, "--lab", "lab.yaml"],
            cwd=folder, env=environment, capture_output=True, text=True,
        )  # fmt: skip

    age, burnt = call("far.age", "of=tube"), call("far.glow", "seconds=1", "colour=#fff")

    assert json.loads(age.stdout) == {"hours": 12.5, "of": "tube"}, age.stderr
    assert burnt.returncode == 1 and "Burnt: too bright for this bulb" in burnt.stderr
