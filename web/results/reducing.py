"""Reduce and map the spectra of a run, as `labrun reduce` and `labrun map` do, one run at a time."""

import asyncio
import os
from collections.abc import Callable
from pathlib import Path

from ...system.tasks import end, spawn
from ..local.command import labrun
from ..local.refusal import Refusal
from ..models.results import Reduction
from .reduced import reduced_names

STEPS = ("reduce", "map")
DOES = {"reduce": "Finding peaks and temperatures.", "map": "Making maps and classes."}
LONGEST_S = 3600.0
LINES = 8
PARTLY = 3  # the status of a reduction in which some files failed; its tables name them
Ended = Callable[[str, Reduction], None]


class Reducing:
    """`place` gives a run's folder, `is_live` whether it still runs; `ended` is called at each end."""

    def __init__(
        self, place: Callable[[str], Path], is_live: Callable[[str], bool], ended: Ended
    ) -> None:
        self._place = place
        self._is_live = is_live
        self._ended = ended
        self._known: dict[str, Reduction] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._turn = asyncio.Lock()

    async def close(self) -> None:
        """End what is under way; a new request starts it again."""
        await end(*self._tasks.values())

    def state(self, id: str) -> Reduction:
        """Its progress, and which tables exist."""
        tables = reduced_names(self._place(id))
        known = self._known.get(id) or Reduction(state="done" if tables else "none")
        return known.model_copy(update={"tables": tables})

    def start(self, id: str) -> Reduction:
        """Start, unless already under way; raises Refusal (409) while the run is live."""
        folder = self._place(id)
        if self._is_live(id):
            raise Refusal(409, "LIVE", f"{id} is running", "reduce its spectra after it has ended")
        if id not in self._tasks:
            self._known[id] = Reduction(state="waiting", text="waiting for another run's reduction")
            task = spawn(f"reduce the spectra of {id}", self._work(id, folder))
            self._tasks[id] = task
            task.add_done_callback(lambda _: self._tasks.pop(id, None))
        return self.state(id)

    async def _work(self, id: str, folder: Path) -> None:
        async with self._turn:
            said = ""
            for step in STEPS:
                self._known[id] = Reduction(state="working", text=DOES[step])
                good, said = await _do(step, folder)
                if not good:
                    self._end(id, Reduction(state="failed", text=said))
                    return
            self._end(id, Reduction(state="done", text=said))

    def _end(self, id: str, state: Reduction) -> None:
        self._known[id] = state
        self._ended(id, state)


async def _do(step: str, folder: Path) -> tuple[bool, str]:
    """Whether a command succeeded, and its last output; one core is left for the bench."""
    more = ["--jobs", str(max(1, (os.cpu_count() or 2) - 1))] if step == "reduce" else []
    status, lines = await labrun(step, str(folder), *more, longest_s=LONGEST_S)
    if status is None:
        return False, f"labrun {step} took longer than {LONGEST_S / 3600:g} h and was stopped"
    good = status in (0, PARTLY)
    if good:  # the files written are reported as tables
        lines = [line for line in lines if not line.startswith("made ")][:LINES]
    return good, "\n".join(lines[-LINES:]).replace(f"{folder}", folder.name)
