"""The driver keeps gantry@2 on a real server, in front of OpenBuilds CONTROL and its GRBL controller."""

import asyncio
import threading
from contextlib import contextmanager

import pytest

from ..gantry_calls import KeepsGantryContract, case_of


@pytest.mark.slow
class TestOpenBuilds(KeepsGantryContract):
    case = case_of("openbuilds")

    @pytest.fixture(autouse=True)
    def _programs(self, peers, program):
        self.peers, self.program = peers, program

    @contextmanager
    def peer(self, folder, *, slow):
        controller = self.started(self.peers, slow=slow)
        with elsewhere(self.program(controller)) as control:
            # On a busy machine it is silent for longer than 2 s, and its port would be opened again.
            yield {"url": control.url, "port": controller.path, "silence_s": 30}


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
