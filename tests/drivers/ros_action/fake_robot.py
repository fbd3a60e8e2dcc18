"""A small robot behind a rosbridge, with the types of Nav2, ros2_control and std_srvs.

Messages are converted as strictly as a rosbridge does: a field that the type does not have, or a
value of another type, is refused. `silent`: it stops answering, as a robot that was killed.

As rosbridge_suite 2.1 started by default: a connection with a goal or a service under way hears
nothing else, the ids of goals are those of all connections, a cancel that precedes the acceptance is
lost, a goal that its server rejects is never answered, and a service that nobody serves is refused.
"""

import asyncio
import json
import threading
from typing import Any

from websockets.asyncio.server import serve

TIME = {"sec": int, "nanosec": int}
HEADER = {"stamp": TIME, "frame_id": str}
POINT, QUATERNION = dict.fromkeys("xyz", float), dict.fromkeys("xyzw", float)
POSE = {"header": HEADER, "pose": {"position": POINT, "orientation": QUATERNION}}
TRAJECTORY_POINT = {
    "positions": [float], "velocities": [float], "accelerations": [float], "effort": [float],
    "time_from_start": TIME,
}  # fmt: skip
TOLERANCE = {"name": str, "position": float, "velocity": float, "acceleration": float}
GOALS = {
    "nav2_msgs/action/NavigateToPose": {"pose": POSE, "behavior_tree": str},
    "control_msgs/action/FollowJointTrajectory": {
        "trajectory": {"header": HEADER, "joint_names": [str], "points": [TRAJECTORY_POINT]},
        "path_tolerance": [TOLERANCE], "goal_tolerance": [TOLERANCE], "goal_time_tolerance": TIME,
    },
}  # fmt: skip
JOINTS = ["pan", "lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


def refused(type: Any, value: Any, where: str = "message") -> str | None:
    """Why a value is not of a type; None if it is."""
    if isinstance(type, dict):
        if not isinstance(value, dict):
            return f"{where} is not a message"
        strange = [name for name in value if name not in type]
        if strange:
            return f"{where} has no field {strange[0]}"
        found = (refused(type[name], one, f"{where}.{name}") for name, one in value.items())
    elif isinstance(type, list):
        if not isinstance(value, list):
            return f"{where} is not a list"
        found = (refused(type[0], one, f"{where}[{i}]") for i, one in enumerate(value))
    else:
        numbers = (int, float) if type is float else (type,)
        good = isinstance(value, numbers) and not isinstance(value, bool)
        return None if good else f"{where} is {value!r}, not a {type.__name__}"
    return next((why for why in found if why is not None), None)


class FakeRobot:
    """In a thread of its own; `sent` is what arrived, `url` its rosbridge."""

    def __init__(self) -> None:
        self.sent: list[dict[str, Any]] = []
        self.cancelled: list[str] = []
        self.actions = ["/navigate_to_pose", "/joint_trajectory_controller/follow_joint_trajectory"]
        self.silent = False
        self.accepts_s = 0.0
        self.jammed = False
        self._goals: dict[str, asyncio.Event] = {}
        self._tasks: set[asyncio.Task] = set()
        self._loop = asyncio.new_event_loop()
        self._up, self._over = threading.Event(), asyncio.Event()
        self._thread = threading.Thread(target=self._loop.run_until_complete, args=(self._run(),))
        self._thread.start()
        assert self._up.wait(10)

    def end(self) -> None:
        self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(10)
        self._loop.close()

    async def _run(self) -> None:
        async with serve(self._serve, "127.0.0.1", 0) as server:
            self.url = f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}"
            self._up.set()
            await self._over.wait()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _serve(self, socket: Any) -> None:
        async for text in socket:
            message = json.loads(text)
            if message["op"] == "cancel_action_goal":
                self.cancelled.append(message["id"])
                if message["id"] in self._goals:
                    self._goals[message["id"]].set()
                continue
            if message["op"] == "subscribe":
                self._tasks.add(asyncio.create_task(self._topic(socket, message)))
            elif message["op"] in ("send_action_goal", "call_service"):
                work = self._goal if message["op"] == "send_action_goal" else self._service
                await work(socket, message)

    async def _goal(self, socket: Any, message: dict[str, Any]) -> None:
        id, name, args = message["id"], message["action"], message["args"]
        said = {"op": "action_result", "id": id, "action": name}
        why = refused(GOALS[message["action_type"]], args)
        if why is not None:
            await socket.send(json.dumps({**said, "values": why, "status": 0, "result": False}))
            return
        self.sent.append(args)
        if name == "/navigate_to_pose" and args["pose"]["pose"]["position"]["y"] < -5:  # rejected
            await socket.wait_closed()
        await asyncio.sleep(self.accepts_s)
        self._goals[id] = asyncio.Event()
        do = self._drive if name == "/navigate_to_pose" else self._move
        status, values = await do(socket, {"id": id, "action": name}, args)
        if not self.silent:
            text = {**said, "values": values, "status": status, "result": True}
            await socket.send(json.dumps(text))

    async def _drive(self, socket: Any, named: dict[str, Any], args: dict) -> tuple[int, dict]:
        where, left = args["pose"]["pose"]["position"], 1.5
        if where["x"] > 5:
            return ABORTED, {"error_code": 204, "error_msg": "the goal is off the global costmap"}
        while left > 0 or where["y"] > 5:  # far in y it never arrives
            values = {"current_pose": {}, "distance_remaining": left, "number_of_recoveries": 0}
            told = {"op": "action_feedback", **named, "values": values}
            await socket.send(json.dumps(told))
            if self._goals[named["id"]].is_set():
                return CANCELED, {"error_code": 0, "error_msg": ""}
            await asyncio.sleep(0.05)
            left -= 0.5
        return SUCCEEDED, {"error_code": 0, "error_msg": ""}

    async def _move(self, socket: Any, named: dict[str, Any], args: dict) -> tuple[int, dict]:
        trajectory = args["trajectory"]
        if trajectory["joint_names"] != JOINTS or len(trajectory["points"][0]["positions"]) != 6:
            return ABORTED, {"error_code": -2, "error_string": "joints do not match"}
        if max(trajectory["points"][0]["positions"]) > 3:
            return ABORTED, {"error_code": -4, "error_string": "lift: error 0.31, tolerance 0.2"}
        return SUCCEEDED, {"error_code": 0, "error_string": "Goal successfully reached!"}

    async def _service(self, socket: Any, message: dict[str, Any]) -> None:
        name, values, good = message["service"], {}, True
        action, _, hidden = name.rpartition("/_action/")
        if hidden == "cancel_goal" and action in self.actions:
            if not message.get("args"):
                self.cancelled.append(f"all of {name}")
        elif name.startswith("/gripper/"):
            words = "the fingers are jammed" if self.jammed else "done"
            values = {"success": not self.jammed, "message": words}
        else:
            values, good = f"Service {name} does not exist", False
        if not (self.silent and name.startswith("/gripper/")):
            said = {"op": "service_response", "service": name, "values": values, "result": good}
            await socket.send(json.dumps({**said, "id": message["id"]}))

    async def _topic(self, socket: Any, message: dict[str, Any]) -> None:
        values: dict[str, Any] = {"name": JOINTS, "position": [0.0, 1.5707963267948966] * 3}
        if message["topic"] == "/amcl_pose":
            turned = {"x": 0.0, "y": 0.0, "z": 1.0, "w": 0.0}
            values = {
                "pose": {
                    "pose": {"position": {"x": 1.0, "y": 2.0, "z": 0.0}, "orientation": turned}
                }
            }
        while True:
            if not self.silent:
                said = {"op": "publish", "topic": message["topic"], "msg": values}
                await socket.send(json.dumps(said))
            await asyncio.sleep(0.1)
