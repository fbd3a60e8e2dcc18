"""The setting of the contract tests for a device server that is no part of labrun, in any language."""

import asyncio
import json
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from ...system.process import apart, stop
from .case import Params
from .served_driver import Stage

START_S = 30.0
END_S = 10.0


class Elsewhere(Stage):
    """What a subclass defines for its server: `case` without a driver, and these methods.

    `happened` as well, if the contract has a `once` action with a probe.
    """

    def command(self, folder: Path, *, slow: bool) -> list[str]:
        """The command line of the server, which keeps its ledger in `folder`.

        It prints one line of JSON, `{"url": "http://127.0.0.1:4107"}`, once it can be reached.
        """
        raise NotImplementedError("a command line that starts the device server")

    def asked(self, folder: Path) -> list[str]:
        """The actions that the instrument was asked for, in order; not the server's own safe state."""
        raise NotImplementedError("the actions that the instrument was asked for")

    @asynccontextmanager
    async def _serving(
        self, folder: Path, config: Params, *, slow: bool
    ) -> AsyncIterator[tuple[str, list[str]]]:
        asked: list[str] = []
        async with self._started(folder, slow=slow) as (url, _):
            yield url, asked
        asked += self.asked(folder)

    @asynccontextmanager
    async def _killable(
        self, folder: Path, config: Params
    ) -> AsyncIterator[tuple[str, asyncio.subprocess.Process]]:
        async with self._started(folder, slow=True) as started:
            yield started

    @asynccontextmanager
    async def _started(
        self, folder: Path, *, slow: bool
    ) -> AsyncIterator[tuple[str, asyncio.subprocess.Process]]:
        command = self.command(folder, slow=slow)
        with (folder / "server.log").open("ab") as log:
            process = await asyncio.create_subprocess_exec(
                *command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log, **apart()
            )
        try:
            assert process.stdout is not None
            async with asyncio.timeout(START_S):
                line = await process.stdout.readline()
            log_text = (folder / "server.log").read_text(encoding="utf-8", errors="replace")
            assert line.strip(), f"{command} ended before it was ready: {log_text}"
            yield str(json.loads(line)["url"]), process
        finally:
            assert await stop(process, END_S) is not None, f"{command} does not end"
