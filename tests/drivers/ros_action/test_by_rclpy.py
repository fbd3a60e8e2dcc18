"""What rclpy's thread passes on; the rest needs ROS, and is tested with it in `tests/web/ros/real`."""

import asyncio
from concurrent.futures import Future

import pytest

from labrun.drivers.ros_action.bridge import Gone
from labrun.drivers.ros_action.by_rclpy import _UnderWay


@pytest.mark.parametrize("step", ["answered", "_resulted"])
def test_an_answer_that_cannot_be_read_ends_its_goal(step):
    async def story():
        under_way = _UnderWay(asyncio.get_running_loop(), None)
        answer = Future()
        answer.set_exception(RuntimeError("no such field"))
        await asyncio.to_thread(getattr(under_way, step), answer)
        return await under_way.ended

    with pytest.raises(Gone, match="its answer cannot be read: no such field"):
        asyncio.run(story())
