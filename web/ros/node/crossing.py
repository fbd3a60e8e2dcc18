"""Between the thread in which ROS spins and our event loop."""

# rclpy exists only where ROS is installed.
# pyright: reportMissingImports=false

import asyncio
import concurrent.futures
from collections.abc import Coroutine
from typing import Any

from rclpy.executors import Executor
from rclpy.task import Future


class Crossing:
    """`loop` is ours, `executor` spins in a separate thread."""

    def __init__(self, loop: asyncio.AbstractEventLoop, executor: Executor) -> None:
        self.loop = loop
        self.executor = executor

    async def over(self, work: Coroutine[Any, Any, Any]) -> Any:
        """Awaited by a ROS callback while the work is done in our loop."""
        done = asyncio.run_coroutine_threadsafe(work, self.loop)
        future = Future(executor=self.executor)

        def resolve(ended: "concurrent.futures.Future[Any]") -> None:
            try:
                future.set_result(ended.result())
            except BaseException as fault:  # it is raised again where the callback awaits it
                future.set_exception(
                    fault if isinstance(fault, Exception) else RuntimeError(str(fault))
                )
            # A future set from another thread does not wake the executor.
            self.executor.wake()

        done.add_done_callback(resolve)
        return await future
