"""PyLabRobot's backend that prints, which also writes down what it was told, and counts it.

It lives in the driver's process; only its file, HANDLER_FILE, outlives that.
"""

import asyncio
import json
import os
from pathlib import Path

from pylabrobot.liquid_handling.backends import LiquidHandlerChatterboxBackend


class Written(LiquidHandlerChatterboxBackend):
    """`dispensed` and `picked` are the numbers of lines in its file."""

    file = Path(os.environ.get("HANDLER_FILE", "handler.jsonl"))

    def _done(self, what, ops):
        with self.file.open("a", encoding="utf-8") as file:
            told = {"done": what, "where": [one.resource.name for one in ops]}
            file.write(json.dumps(told) + "\n")

    def _count(self, what):
        lines = self.file.read_text("utf-8").splitlines() if self.file.exists() else []
        return sum(json.loads(line)["done"] == what for line in lines)

    @property
    def dispensed(self):
        return self._count("dispense")

    @property
    def picked(self):
        return self._count("pick")

    async def pick_up_tips(self, ops, use_channels, **more):
        self._done("pick", ops)

    async def aspirate(self, ops, use_channels, **more):
        self._done("aspirate", ops)

    async def dispense(self, ops, use_channels, **more):
        await asyncio.sleep(float(os.environ.get("HANDLER_WORK_S", "0")))
        self._done("dispense", ops)
