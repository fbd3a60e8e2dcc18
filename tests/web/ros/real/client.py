"""A client of the real ROS 2 does what it is asked; a JSON object of what came of it on stdout.

Run by the Python of the environment with ROS: `client.py NAME`.
"""

import functools
import json
import os
import signal
import statistics
import sys
import time

import py_trees
import rclpy
from custom_interfaces.action import MoveGantry
from labrun_interfaces.action import LampBeacon, LampGlow, RunProtocol
from labrun_interfaces.msg import LampStatus
from labrun_interfaces.srv import LampAge
from rclpy.action import ActionClient, get_action_names_and_types
from rclpy.executors import SingleThreadedExecutor

FOUND_S, WAIT_S = 500, 500
SETTLE_S = 1.5
"""Between being discovered and the first goal."""


class Client:
    def __init__(self):
        rclpy.init()
        self.node = rclpy.create_node("client")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)

    def action(self, type, name):
        client = ActionClient(self.node, type, name)
        assert client.wait_for_server(FOUND_S), f"nobody serves {name}"
        time.sleep(SETTLE_S)
        return client

    def wait(self, future, wait_s=WAIT_S):
        self.executor.spin_until_future_complete(future, timeout_sec=wait_s)
        assert future.done(), "no answer"
        return future.result()

    def send(self, client, goal):
        heard = []
        sending = client.send_goal_async(
            goal, feedback_callback=lambda told: heard.append(told.feedback)
        )
        return self.wait(sending), heard

    def end(self, handle):
        return self.wait(handle.get_result_async())


def goals(ros):
    glow = ros.action(LampGlow, "/Lamp_9/glow")
    handle, heard = ros.send(glow, LampGlow.Goal(seconds=0.2, pattern=[1, 2], colour="warm white"))
    good = ros.end(handle)
    rejected = [ros.send(glow, goal)[0].accepted for goal in (
        LampGlow.Goal(seconds=-1.0), LampGlow.Goal(seconds=1.0, colour="blue"),
        LampGlow.Goal(seconds=float("nan")), LampGlow.Goal(seconds=1.0, extra_json="{"),
    )]  # fmt: skip
    burnt = ros.end(ros.send(glow, LampGlow.Goal(seconds=1.0, colour="#fff"))[0])
    return {
        "accepted": handle.accepted, "status": good.status, "pattern": list(good.result.pattern),
        "feedback": [told.message for told in heard], "rejected": rejected,
        "burnt": [burnt.status, burnt.result.error_name, burnt.result.error_happened],
    }  # fmt: skip


def cancels(ros):
    glow = ros.action(LampGlow, "/Lamp_9/glow")
    seen = []
    for _ in range(40):
        handle, _ = ros.send(glow, LampGlow.Goal(seconds=60.0))
        canceling = ros.wait(handle.cancel_goal_async()).goals_canceling
        seen.append((len(canceling), ros.end(handle).status))
    beacon = ros.action(LampBeacon, "/Lamp_9/beacon")
    handle, _ = ros.send(beacon, LampBeacon.Goal())
    refused = ros.wait(handle.cancel_goal_async()).goals_canceling
    return {"seen": sorted({*map(tuple, seen)}), "count": len(seen), "beacon": len(refused)}


def reads(ros):
    heard = []
    ros.node.create_subscription(LampStatus, "/Lamp_9/status", heard.append, 10)
    age = ros.node.create_client(LampAge, "/Lamp_9/age")
    assert age.wait_for_service(FOUND_S)
    time.sleep(SETTLE_S)
    tube, nothing = [
        ros.wait(age.call_async(LampAge.Request(of=[of]))) for of in ("tube", "nothing")
    ]
    until = time.monotonic() + WAIT_S
    while not heard and time.monotonic() < until:
        ros.executor.spin_once(timeout_sec=0.1)
    return {
        "hours": list(tube.hours), "error": nothing.error_name, "colour": heard[0].colour,
        "levels": list(heard[0].levels), "x": heard[0].place.x,
    }  # fmt: skip


def lost(ros):
    glow = ros.action(LampGlow, "/Lamp_9/glow")
    handle, _ = ros.send(glow, LampGlow.Goal(seconds=60.0))
    ending = handle.get_result_async()
    os.kill(int(os.environ["LAMP_PID"]), signal.SIGKILL)
    end = ros.wait(ending, 20)
    return {"status": end.status, "error": end.result.error_name}


def protocol(ros):
    run = ros.action(RunProtocol, "/labrun/run_protocol")
    handle, _ = ros.send(
        run, RunProtocol.Goal(protocol="glowing.yaml", params_json='{"there": "30 mm"}')
    )
    end = ros.end(handle)
    bad, _ = ros.send(run, RunProtocol.Goal(protocol="nothing"))
    return {
        "status": end.status, "fate": end.result.fate, "run": end.result.run,
        "outputs": json.loads(end.result.outputs_json), "bad": bad.accepted,
    }  # fmt: skip


def paper(ros):
    move = ros.action(MoveGantry, "/move_gantry")
    good, bad = [ros.send(move, MoveGantry.Goal(cmd=cmd))[0] for cmd in ("G90 G0 X5", "M3")]
    end = ros.end(good)
    return {"status": end.status, "msg": end.result.msg, "bad": bad.accepted}


class Ask(py_trees.behaviour.Behaviour):
    """Sends a goal when it begins, looks at what came of it, cancels when it is interrupted."""

    def __init__(self, client, goal):
        super().__init__("ask")
        self.client, self.goal = client, goal

    def initialise(self):
        self.handle = self.ending = self.end = None
        self.client.send_goal_async(self.goal).add_done_callback(self.answered)

    def answered(self, sending):
        self.handle = sending.result()
        if self.handle.accepted:
            self.ending = self.handle.get_result_async()
            self.ending.add_done_callback(functools.partial(setattr, self, "end"))

    def update(self):
        if self.handle is not None and not self.handle.accepted:
            return py_trees.common.Status.FAILURE
        if self.end is None:
            return py_trees.common.Status.RUNNING
        good = self.end.result().status == 4
        return py_trees.common.Status.SUCCESS if good else py_trees.common.Status.FAILURE

    def terminate(self, new_status):
        running, invalid = py_trees.common.Status.RUNNING, py_trees.common.Status.INVALID
        if (self.status, new_status) == (running, invalid):
            self.handle.cancel_goal_async()


def tree(ros):
    glow = ros.action(LampGlow, "/Lamp_9/glow")

    def ticked(goal, enough):
        behaviour = Ask(glow, goal)
        root = py_trees.trees.BehaviourTree(py_trees.composites.Sequence("root", True, [behaviour]))
        until = time.monotonic() + WAIT_S
        while not enough(behaviour) and time.monotonic() < until:
            root.tick()
            ros.executor.spin_once(timeout_sec=0.02)
        return root, behaviour

    def ended(behaviour):
        return behaviour.status not in (
            py_trees.common.Status.INVALID, py_trees.common.Status.RUNNING,
        )  # fmt: skip

    goals = {
        "good": LampGlow.Goal(seconds=0.2), "burnt": LampGlow.Goal(seconds=1.0, colour="#fff"),
        "rejected": LampGlow.Goal(seconds=-1.0),
    }  # fmt: skip
    told = {name: ticked(goal, ended)[0].root.status.name for name, goal in goals.items()}
    root, behaviour = ticked(LampGlow.Goal(seconds=60.0), lambda one: getattr(one, "ending", None))
    root.root.stop(py_trees.common.Status.INVALID)
    canceled = ros.wait(behaviour.ending).status
    return {**told, "interrupted": behaviour.status.name, "canceled": canceled}


def graph(ros):
    until = time.monotonic() + FOUND_S
    while time.monotonic() < until:
        actions = dict(get_action_names_and_types(ros.node))
        if "/labrun/run_protocol" in actions:
            break
        time.sleep(0.2)
    time.sleep(SETTLE_S)
    (info,) = ros.node.get_publishers_info_by_topic("/Lamp_9/status")
    return {
        "actions": actions, "topics": dict(ros.node.get_topic_names_and_types()),
        "services": dict(ros.node.get_service_names_and_types()), "node": info.node_name,
        "qos": [info.qos_profile.reliability.name, info.qos_profile.durability.name],
    }  # fmt: skip


def speed(ros):
    glow = ros.action(LampGlow, "/Lamp_9/glow")
    times = []
    for _ in range(100):
        began = time.perf_counter()
        ros.end(ros.send(glow, LampGlow.Goal(seconds=0.0))[0])
        times.append(time.perf_counter() - began)
    return {"median_ms": 1e3 * statistics.median(times)}


print(json.dumps(globals()[sys.argv[1]](Client())), flush=True)
os._exit(0)  # rclpy's own end is not what is looked at
