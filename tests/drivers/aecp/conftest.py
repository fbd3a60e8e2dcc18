"""A bench with the analyser server in a process of its own, and the driver beside the test."""

import asyncio
import json
import subprocess
import sys
from pathlib import Path

import pytest

from labrun.drivers.aecp.driver import Aecp
from labrun.drivers.driver import GoalContext, Place

SERVER = Path(__file__).with_name("analyser_server.py")
QUICK = {"connect_s": 30, "measure_s": 30, "export_s": 30, "locate_s": 30, "settle_s": 0.4}


class AecpBench:
    """One folder that the server and the driver share, as two machines share an export folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.port = 0
        self.process: subprocess.Popen[str] | None = None

    def start(self, **options) -> None:
        given = json.dumps({"port": self.port, "folder": str(self.folder), **options})
        self.process = subprocess.Popen(
            [sys.executable, "-W", "ignore", str(SERVER), given],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        assert self.process.stdout is not None
        self.port = int(self.process.stdout.readline().split()[1])

    def end(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None

    async def again(self, **options) -> None:
        """Start the server anew on its port, once the last one is gone."""
        assert self.process is not None
        await asyncio.to_thread(self.process.wait)
        self.end()
        self.start(**options)

    def driver(self, **config) -> Aecp:
        known = {"url": f"http://127.0.0.1:{self.port}", "exports": str(self.folder / "exports")}
        place = Place("libs", {**known, **QUICK, **config}, {}, self.folder / "mine", self.folder)
        return Aecp(place)

    @property
    def cache(self) -> str:
        return str(self.folder / "cache")

    def shots(self) -> int:
        log = self.folder / "shots.log"
        return len(log.read_text().splitlines()) if log.exists() else 0

    def play(self, story, **config):
        """Run a story with an open driver."""

        async def played():
            driver = self.driver(**config)
            await driver.open()
            try:
                return await story(driver)
            finally:
                await driver.close()

        return asyncio.run(played())


def goal(name: str) -> GoalContext:
    return GoalContext(name)


@pytest.fixture
def aecp(tmp_path):
    bench = AecpBench(tmp_path)
    yield bench
    bench.end()
