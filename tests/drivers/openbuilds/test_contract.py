"""The driver keeps gantry@2 on a real server, in front of OpenBuilds CONTROL and its GRBL controller."""

import asyncio
import threading
from contextlib import contextmanager

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract

from ..gantry_calls import BAD, CONFIG, GOOD, NEEDS


@pytest.mark.slow
class TestOpenBuilds(KeepsContract):
    case = Case(
        driver="openbuilds",
        good=GOOD,
        config=CONFIG,
        bad=BAD,
        needs=NEEDS,
        quick=frozenset({"set_zero"}),
        lasting="move_to",
    )

    @pytest.fixture(autouse=True)
    def _programs(self, peers, program):
        self.peers, self.program = peers, program

    @contextmanager
    def peer(self, folder, *, slow):
        self.controller = self.peers(speed=1 if slow else 20, homing_s=3 if slow else None)
        self.controller.surface = -80.0
        with elsewhere(self.program(self.controller)) as control:
            yield {"url": control.url, "port": self.controller.path}

    def is_safe(self, status):
        return self.controller.move is None and status["state"] in ("idle", "alarm")

    def happened(self, folder, goal_id):
        """A controller knows of no goals: after homing only what the test did moves it."""
        return len(self.controller.stands) > 1 or any(self.controller.offset)


@contextmanager
def elsewhere(control):
    """CONTROL in a loop and a thread of its own: it outlives every server of the test."""
    ready, over = threading.Event(), asyncio.Event()
    loops = []

    async def live():
        async with control:
            loops.append(asyncio.get_running_loop())
            ready.set()
            await over.wait()

    thread = threading.Thread(target=lambda: asyncio.run(live()), daemon=True)
    thread.start()
    assert ready.wait(10)
    try:
        yield control
    finally:
        loops[0].call_soon_threadsafe(over.set)
        thread.join(10)
