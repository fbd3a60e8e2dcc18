"""Snapshots: what a camera sees now becomes a file of a run, with its time, device and person."""

import asyncio
import logging
from pathlib import Path

from ...engine.run.snapshots import add_snapshot, read_snapshots
from ..devices.looking import Looking
from ..local.refusal import Refusal
from ..models.finding import RunSnapshot
from ..report.report import make
from .runs import Runs

LOG = logging.getLogger("labrun")


class Snapshots:
    """Takes pictures into runs, live or over."""

    def __init__(self, runs: Runs, looking: Looking) -> None:
        self._runs = runs
        self._looking = looking
        self._one_at_a_time = asyncio.Lock()

    def of(self, id: str) -> list[RunSnapshot]:
        """Those of a run, oldest first."""
        return [RunSnapshot.of(one) for one in read_snapshots(self._runs.place(id))]

    async def take(self, id: str, device: str, by: str) -> RunSnapshot:
        """Look now and keep the picture; raises Refusal. The report of a run that is over is made again."""
        folder = self._runs.place(id)
        look, suffix = await self._looking.look(device, now=True)
        picture = look.file.data
        async with self._one_at_a_time:
            try:
                told = await asyncio.to_thread(add_snapshot, folder, picture, suffix, device, by)
            except OSError as fault:
                why = f"the picture cannot be kept: {fault.strerror}"
                raise Refusal(507, "NO_ROOM", why) from fault
            if not self._runs.is_live(id):
                await asyncio.to_thread(_report, folder)
        return RunSnapshot.of(told)


def _report(folder: Path) -> None:
    try:
        make(folder)
    except Exception:  # whatever it was: the snapshot is kept, and the log says why
        LOG.exception("the report of %s was not made again", folder.name)
