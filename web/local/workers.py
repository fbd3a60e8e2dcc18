"""The parent's side of a worker: started when first needed, killed if it takes too long."""

import asyncio
import json
import logging
from typing import Any

from ...system.process import start_python
from ..models.base import Fault
from .refusal import Refusal, Refused

LOG = logging.getLogger("labrun")
LONGEST_LINE = 64 * 1024 * 1024
END_S = 5.0


class WorkFailed(Exception):
    """The worker failed; `kind` is the name of the exception."""

    def __init__(self, kind: str, message: str) -> None:
        super().__init__(message)
        self.kind = kind


class Worker:
    """One process, one request at a time."""

    def __init__(self) -> None:
        self._process: asyncio.subprocess.Process | None = None
        self._turn = asyncio.Lock()

    async def ask(self, work: str, asked: dict[str, Any], timeout_s: float) -> dict[str, Any]:
        """The worker's answer; raises Refusal if it refuses or takes too long, else WorkFailed."""
        async with self._turn:
            try:
                async with asyncio.timeout(timeout_s):
                    answer = await self._exchange(work, asked)
            except TimeoutError:
                await self._end()
                raise Refusal(
                    422, "TOO_LONG", f"it took longer than {timeout_s:g} s and was abandoned",
                    "shorten it, or ask `labrun check` in a terminal, which waits as long as it takes",
                ) from None  # fmt: skip
            except BaseException:  # raised again: a process in the middle of an exchange is no use
                await self._end()
                raise
        if answer["ok"]:
            return answer["told"]
        if "fault" in answer:
            raise Refused(answer["status"], Fault(**answer["fault"]))
        failed = WorkFailed(answer["kind"], answer["message"])
        LOG.error("%s failed in its process\n%s", work, answer["trace"])
        raise failed

    async def close(self) -> None:
        """End the process."""
        await self._end()

    async def _exchange(self, work: str, asked: dict[str, Any]) -> dict[str, Any]:
        if self._process is None or self._process.returncode is not None:
            self._process = await start_python(
                "labrun.web.server.worker", stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.DEVNULL, limit=LONGEST_LINE,
            )  # fmt: skip
        process = self._process
        assert process.stdin is not None and process.stdout is not None
        process.stdin.write(json.dumps({"work": work, "asked": asked}).encode() + b"\n")
        await process.stdin.drain()
        line = await process.stdout.readline()
        if not line:
            raise Refusal(503, "ENDED", "the worker process has ended", "try again")
        return json.loads(line)

    async def _end(self) -> None:
        process, self._process = self._process, None
        if process is None or process.returncode is not None:
            return
        process.kill()
        async with asyncio.timeout(END_S):
            await process.wait()


class Workers:
    """Separate processes for work that must not wait for other work; each starts when needed."""

    def __init__(self) -> None:
        self.checks = Worker()
        self.rehearsals = Worker()
        self.fits = Worker()

    async def close(self) -> None:
        """End them all."""
        await asyncio.gather(*(one.close() for one in (self.checks, self.rehearsals, self.fits)))
