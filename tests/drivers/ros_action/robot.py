"""A ROS system with a robot in it: an arm that counts in metres, seen through a rosbridge."""

import os
import subprocess
import sys
import time
from pathlib import Path

ROBOT_LAB = """
name: the robot
simulated: true
contracts: [./ros_arm.yaml]
devices:
  arm: {contract: ros_arm@1, driver: "./ros_arm.py:RosArm"}
"""
ROS_ARM = """
type: ros_arm@1
summary: The robot as it sees itself
status:
  type: object
  properties:
    state: {enum: [IDLE, BUSY]}
    pose: {type: object, properties: {x: {type: number, unit: m}, y: {type: number, unit: m}}}
actions:
  reach:
    effect: idempotent
    cancel: true
    params:
      type: object
      required: [target]
      properties:
        target: {type: object, properties: {x: {type: number, unit: m}, y: {type: number, unit: m}}}
        frame: {type: string}
        seconds: {type: number, unit: s}
        speed: {type: number, unit: m/s}
    returns:
      type: object
      required: [final]
      properties: {final: {type: object, properties: {x: {type: number}, y: {type: number}}}}
    errors: {TooFar: {happened: no}, Tired: {happened: yes}}
  rest: {effect: idempotent}
"""
ROS_ARM_DRIVER = """
import asyncio

from labrun.drivers.driver import ActionCanceled, ActionFailed, Driver


class RosArm(Driver):
    contract = "ros_arm@1"
    state, x, y = "IDLE", 0.0, 0.0

    async def status(self):
        return {"state": self.state, "pose": {"x": self.x, "y": self.y}}

    async def reach(self, goal, *, target, frame="", speed=0.25, seconds=0):
        if frame != "bench":
            raise ActionFailed("Tired", f"which frame is {frame!r}?")
        if target["x"] > 1:
            raise ActionFailed("TooFar", f"{target['x']} m is out of reach at {speed} m/s")
        self.state = "BUSY"
        try:
            goal.feedback(0.0, "reaching")
            async with asyncio.timeout(seconds):
                await goal.cancelled.wait()
        except TimeoutError:
            self.x, self.y = target["x"], target.get("y", self.y)
            return {"final": {"x": self.x, "y": self.y}}
        finally:
            self.state = "IDLE"
        raise ActionCanceled

    async def rest(self, goal):
        return {}
"""
ARM = """
type: arm@1
summary: The robot as protocols see it, in millimetres of the bench
safe_state: [rest]
status:
  type: object
  properties: {state: {enum: [IDLE, BUSY]}, x: {type: number, unit: mm}, y: {type: number, unit: mm}}
actions:
  reach:
    effect: idempotent
    cancel: true
    duration: 2 s
    params:
      type: object
      additionalProperties: false
      required: [x]
      properties:
        x: {type: number, unit: mm, minimum: 0, maximum: 2000}
        y: {type: number, unit: mm}
        speed: {type: number, unit: mm/s, exclusiveMinimum: 0}
    returns:
      type: object
      required: [x, y]
      properties: {x: {type: number, unit: mm}, y: {type: number, unit: mm}}
    errors: {TooFar: {happened: no}, Stuck: {happened: unknown}}
  rest: {effect: idempotent}
"""


def config(bridge: str, *, seconds: float = 0.0, node: bool = False) -> dict:
    """The lab's `config` for the arm behind ROS; the robot counts in metres."""
    reach = {
        "action": "/arm/reach", "type": "labrun_interfaces/action/RosArmReach",
        "goal": {
            "x": {"field": "target.x", "unit": "m"}, "y": {"field": "target.y", "unit": "m"},
            "speed": {"field": "speed", "unit": "m/s", "optional": True},
        },
        "result": {"x": {"field": "final.x", "unit": "m"}, "y": {"field": "final.y", "unit": "m"}},
        "constants": {"frame": "bench", "seconds": [seconds]}, "aborted": "Stuck",
    }  # fmt: skip
    rest = {"action": "/arm/rest", "type": "labrun_interfaces/action/RosArmRest"}
    fields = {"x": {"field": "pose.x", "unit": "m"}, "y": {"field": "pose.y", "unit": "m"}}
    status = {
        "topic": "/arm/status",
        "type": "labrun_interfaces/msg/RosArmStatus",
        "fields": fields,
    }
    way = {"node": True} if node else {"bridge": bridge}
    return {**way, "actions": {"reach": reach, "rest": rest}, "status": status}


def write_robot(folder: Path) -> Path:
    """The robot's own lab, and beside it the contract by which protocols see it."""
    (folder / "robot.yaml").write_text(ROBOT_LAB)
    (folder / "ros_arm.yaml").write_text(ROS_ARM)
    (folder / "ros_arm.py").write_text(ROS_ARM_DRIVER)
    (folder / "arm.yaml").write_text(ARM)
    return folder / "robot.yaml"


def start_robot(folder: Path, port: int) -> subprocess.Popen:
    """The robot behind a rosbridge at this port; returns once it listens."""
    lab = write_robot(folder)
    command = [
        sys.executable,
        "-P",
        "-m",
        "labrun.engine",
        "ros",
        "--lab",
        str(lab),
        "--port",
        str(port),
        "--no-token",  # where the system cannot tell whose program it is, it would be asked for one
    ]
    with (folder / "ros.log").open("wb") as log:
        process = subprocess.Popen(
            command, cwd=folder, stdout=log, stderr=log, env={**os.environ, "PYTHONUNBUFFERED": "1"}
        )
    until = time.monotonic() + 500
    while b"Ctrl-C" not in (folder / "ros.log").read_bytes():
        assert process.poll() is None and time.monotonic() < until, (folder / "ros.log").read_text()
        time.sleep(0.05)
    return process


def end_robot(folder: Path, process: subprocess.Popen) -> None:
    """Ctrl-C, and a look at what it had to say."""
    process.terminate()

    assert process.wait() == 0
    assert "Traceback" not in (folder / "ros.log").read_text()
