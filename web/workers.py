"""The other end of a worker: started when it is first needed, killed where it takes too long."""

import asyncio
import json
import sys
from typing import Any

from .guard.refusal import Refusal, Refused
from .models.told import Fault

LONGEST_LINE = 64 * 1024 * 1024
END_S = 5.0


class WorkFailed(Exception):
    """The worker could not do it; `kind` is the name of what it raised."""

    def __init__(self, kind: str, message: str) -> None:
        super().__init__(message)
        self.kind = kind


class Worker:
    """One process, one request at a time."""

    def __init__(self) -> None:
        self._process: asyncio.subprocess.Process | None = None
        self._turn = asyncio.Lock()

    async def ask(self, work: str, asked: dict[str, Any], timeout_s: float) -> dict[str, Any]:
        """What the worker answers; raises Refusal where it refuses or takes too long, else WorkFailed."""
        async with self._turn:
            try:
                async with asyncio.timeout(timeout_s):
                    answer = await self._exchange(work, asked)
            except TimeoutError:
                await self._end()
                raise Refusal(
                    422, "TOO_LONG", f"it took longer than {timeout_s:g} s and was given up",
                    "a pattern with a repetition in a repetition, such as (a+)+, may take for ever",
                ) from None  # fmt: skip
            except BaseException:
                await self._end()
                raise
        if answer["ok"]:
            return answer["told"]
        if "fault" in answer:
            raise Refused(answer["status"], Fault(**answer["fault"]))
        failed = WorkFailed(answer["kind"], answer["message"])
        failed.add_note(answer["trace"])
        raise failed

    async def close(self) -> None:
        """End the process."""
        await self._end()

    async def _exchange(self, work: str, asked: dict[str, Any]) -> dict[str, Any]:
        if self._process is None or self._process.returncode is not None:
            self._process = await asyncio.create_subprocess_exec(
                sys.executable, "-P", "-m", "labrun.web.worker",
                stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.DEVNULL, limit=LONGEST_LINE,
            )  # fmt: skip
        process = self._process
        assert process.stdin is not None and process.stdout is not None
        process.stdin.write(json.dumps({"work": work, "asked": asked}).encode() + b"\n")
        await process.stdin.drain()
        line = await process.stdout.readline()
        if not line:
            raise Refusal(503, "ENDED", "the process that computes has ended", "ask again")
        return json.loads(line)

    async def _end(self) -> None:
        process, self._process = self._process, None
        if process is None or process.returncode is not None:
            return
        process.kill()
        async with asyncio.timeout(END_S):
            await process.wait()


class Workers:
    """One process each for what must not wait for the other; none is started before it is needed."""

    def __init__(self) -> None:
        self.checks = Worker()
        self.rehearsals = Worker()
        self.fits = Worker()

    async def close(self) -> None:
        """End them all."""
        await asyncio.gather(*(one.close() for one in (self.checks, self.rehearsals, self.fits)))
