"""From the thread that ROS spins in to our event loop, and back."""

# rclpy is only where ROS is.
# pyright: reportMissingImports=false

import asyncio
import concurrent.futures
from collections.abc import Coroutine
from typing import Any

from rclpy.executors import Executor
from rclpy.task import Future


class Crossing:
    """`loop` is ours, `executor` spins in a thread of its own."""

    def __init__(self, loop: asyncio.AbstractEventLoop, executor: Executor) -> None:
        self.loop = loop
        self.executor = executor

    async def over(self, work: Coroutine[Any, Any, Any]) -> Any:
        """Awaited by a callback of ROS: the work is done in our loop meanwhile."""
        done = asyncio.run_coroutine_threadsafe(work, self.loop)
        future = Future(executor=self.executor)

        def settle(ended: "concurrent.futures.Future[Any]") -> None:
            try:
                future.set_result(ended.result())
            except BaseException as fault:  # it is raised again where the callback awaits it
                future.set_exception(
                    fault if isinstance(fault, Exception) else RuntimeError(str(fault))
                )
            # A future that is set from another thread wakes nobody by itself.
            self.executor.wake()

        done.add_done_callback(settle)
        return await future
