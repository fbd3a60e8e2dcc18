"""The labs of `docs/how-to/ros-robots.md`, each against a small fake of its robot."""

import asyncio
import json
import re
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext, Place
from labrun.drivers.ros_action.bridge import Gone
from labrun.drivers.ros_action.driver import RosAction
from labrun.engine.lab.lab import load_lab

from .fake_robot import FakeRobot

DOC = Path(__file__).parents[3] / "docs" / "how-to" / "ros-robots.md"
FILES = dict(re.findall(r"```yaml\n# (\S+)\n(.*?)```", DOC.read_text(), re.DOTALL))


@pytest.fixture
def robot():
    fake = FakeRobot()
    yield fake
    fake.end()


@pytest.fixture
def device(robot, tmp_path):
    """`device(name, **config)`: the driver of a lab in the manual, open, as a context."""

    @asynccontextmanager
    async def opened(name, silent_s=500, **more):
        own = {"ws://10.0.0.9:9090": robot.url, "silent_s: 3": f"silent_s: {silent_s}"}
        for file, text in FILES.items():
            for was, becomes in own.items():
                text = text.replace(was, becomes)
            (tmp_path / file).write_text(text)
        lab, problems = load_lab(tmp_path / f"{name}_lab.yaml")
        assert lab is not None and not problems
        (label,) = lab.lab.devices
        kept = lab.lab.devices[label]
        place = Place(
            label, {**kept.config, **more}, {}, tmp_path, tmp_path, lab.contracts[kept.contract]
        )
        driver = RosAction(place)
        await driver.open()
        try:
            yield driver
        finally:
            await driver.close()

    return opened


async def arrived(robot):
    async with asyncio.timeout(500):
        while not robot.sent:  # noqa: ASYNC110 - in the thread of the fake
            await asyncio.sleep(0.02)


def goal(**more):
    told = []
    return GoalContext("g", tell=lambda progress, words: told.append(words), **more), told


def test_every_file_of_the_manual_is_tried():
    assert sorted(FILES) == [
        "arm.yaml", "arm_lab.yaml", "base_lab.yaml", "gripper.yaml", "gripper_lab.yaml", "mobile_base.yaml",
    ]  # fmt: skip


def test_a_base_is_driven_to_a_pose_and_tells_how_far_it_is(device, robot):
    async def story():
        async with device("base") as base:
            going, told = goal()
            await base.go_to(going, x=1.2, y=0.4, heading=90.0)
            return told, await base.status()

    told, status = asyncio.run(story())

    (sent,) = robot.sent
    pose = sent["pose"]["pose"]
    assert sent["pose"]["header"] == {"frame_id": "map"}
    assert pose["position"] == {"x": 1.2, "y": 0.4}
    assert pose["orientation"] == pytest.approx({"x": 0, "y": 0, "z": 0.5**0.5, "w": 0.5**0.5})
    assert told[0] == "1.50 m to go"
    assert status == pytest.approx({"x": 1.0, "y": 2.0, "heading": 180.0})


def failed(device, name, do):
    async def story():
        async with device(name) as opened:
            with pytest.raises(ActionFailed) as fault:
                await do(opened)
            return fault.value

    return asyncio.run(story())


def test_why_nav2_gave_up_is_the_contracts_error(device):
    fault = failed(device, "base", lambda base: base.go_to(goal()[0], x=6.0, y=0.0, heading=0.0))

    assert (fault.name, fault.happened) == ("NoWay", None)
    assert "the goal is off the global costmap" in str(fault)


def test_an_arm_gets_its_joints_in_radians_and_its_time_in_nanoseconds(device, robot):
    async def story():
        async with device("arm") as arm:
            await arm.move_joints(goal()[0], joints=[0.0, 90, 0, 0, 0, 0], seconds=2.5)
            await arm.move_joints(goal()[0], joints=[0.0, 45, 0, 0, 0, 0], seconds=0.1)
            return await arm.status()

    status = asyncio.run(story())

    first, second = (one["trajectory"]["points"][0] for one in robot.sent)
    assert first["positions"] == pytest.approx([0, 1.5707963, 0, 0, 0, 0])
    assert first["time_from_start"] == {"sec": 2, "nanosec": 500_000_000}
    assert second["positions"] == pytest.approx([0, 0.78539816, 0, 0, 0, 0])
    assert len(robot.sent[1]["trajectory"]["points"]) == 1
    assert status["joints"] == pytest.approx([0, 90] * 3)


def test_a_code_of_the_controller_is_the_contracts_error_with_its_words(device):
    fault = failed(
        device,
        "arm",
        lambda arm: arm.move_joints(goal()[0], joints=[0.0, 179, 0, 0, 0, 0], seconds=1),
    )

    assert (fault.name, str(fault)) == ("OffPath", "OffPath: lift: error 0.31, tolerance 0.2")


def test_a_trigger_is_called_and_its_failure_is_the_contracts_error(device, robot):
    async def story():
        async with device("gripper") as gripper:
            assert await gripper.release(goal()[0]) == {}
            robot.jammed = True
            with pytest.raises(ActionFailed, match="Jammed: the fingers are jammed") as fault:
                await gripper.grip(goal()[0])
            return fault.value.name

    assert asyncio.run(story()) == "Jammed"


def test_a_robot_that_is_gone_is_noticed(device, robot):
    """As after `kill -9`: the bridge still answers, the action server is no longer there."""

    async def story():
        async with device("base", gone_s=1) as base:
            driving = asyncio.create_task(base.go_to(goal()[0], x=1.0, y=6.0, heading=0.0))
            await arrived(robot)
            robot.actions.remove("/navigate_to_pose")
            with pytest.raises(ActionFailed, match="its action server is gone") as fault:
                await driving  # which would never arrive
            await base.safe()
            return fault.value

    fault = asyncio.run(story())

    assert (fault.name, fault.happened) == ("Lost", "unknown")
    assert robot.cancelled and "all of" not in " ".join(robot.cancelled)  # nobody is there to do it


def test_a_goal_whose_action_was_broken_off_is_cancelled(device, robot):
    async def story():
        async with device("base") as base:
            driving = asyncio.create_task(base.go_to(goal()[0], x=1.0, y=6.0, heading=0.0))
            await arrived(robot)
            driving.cancel()
            await asyncio.gather(driving, return_exceptions=True)
            await base.safe()

    asyncio.run(story())

    assert robot.cancelled


def test_a_goal_that_is_never_answered_does_not_keep_the_next_from_the_robot(device, robot):
    async def story():
        async with device("base") as base:
            rejected = asyncio.create_task(base.go_to(goal()[0], x=1.0, y=-6.0, heading=0.0))
            await arrived(robot)
            rejected.cancel()
            await asyncio.gather(rejected, return_exceptions=True)
            await base.go_to(goal()[0], x=1.2, y=0.4, heading=90.0)

    asyncio.run(story())

    assert len(robot.sent) == 2


def test_a_topic_that_falls_silent_is_a_fault_of_the_device(device, robot):
    async def story():
        async with device("arm", silent_s=0.5) as arm:
            robot.silent = True
            with pytest.raises(Gone, match="nothing was heard on /joint_states for") as fault:
                while True:
                    await arm.status()
                    await asyncio.sleep(0.1)
            return fault.value

    assert "is the robot on?" in str(asyncio.run(story()))


def test_a_service_that_does_not_answer_ends_after_its_time(device, robot):
    async def story():
        async with device("gripper") as gripper:
            gripper._config.actions["release"] = replace(
                gripper._config.actions["release"], answer_s=0.5
            )
            robot.silent = True
            with pytest.raises(ActionFailed, match=r"did not answer within 0\.5 s") as fault:
                await gripper.release(goal()[0])
            return fault.value

    fault = asyncio.run(story())

    assert (fault.name, fault.happened) == ("Lost", "unknown")


def test_a_stop_cancels_the_drivers_own_goals_and_no_others(device, robot):
    async def story():
        async with device("base") as base:
            driving = asyncio.create_task(base.go_to(goal()[0], x=1.0, y=6.0, heading=0.0))
            await arrived(robot)
            await base.safe()
            with pytest.raises(ActionFailed, match="cancelled"):
                await driving

    asyncio.run(story())

    assert len({*robot.cancelled}) == 1
    assert robot.cancelled[0].startswith("send_action_goal:/navigate_to_pose")


def test_what_a_killed_session_left_under_way_is_cancelled_by_the_next(device, robot, tmp_path):
    (tmp_path / "goals.json").write_text(json.dumps({"ab" * 16: "go_to"}))

    async def story():
        async with device("base") as base:
            await base.safe()
            await base.safe()

    asyncio.run(story())

    assert robot.cancelled == ["all of /navigate_to_pose/_action/cancel_goal"]
    assert json.loads((tmp_path / "goals.json").read_text()) == {}


@pytest.mark.parametrize("accepts_s", [0.0, 0.3])
def test_a_cancel_of_the_goal_reaches_the_robot_also_before_it_has_accepted(
    device, robot, accepts_s
):
    robot.accepts_s = accepts_s

    async def story():
        async with device("base") as base:
            going, _ = goal()
            driving = asyncio.create_task(base.go_to(going, x=1.0, y=6.0, heading=0.0))
            await arrived(robot)
            going.cancelled.set()
            with pytest.raises(ActionCanceled):
                await driving

    asyncio.run(story())
