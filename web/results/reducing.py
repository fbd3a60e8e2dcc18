"""Reduce and map the spectra of a run, as the two commands of these names do, one run at a time."""

import asyncio
import os
import sys
from collections.abc import Callable
from pathlib import Path

from ..guard.refusal import Refusal
from ..models.results import Reduction
from .reduced import reduced_names

STEPS = ("reduce", "map")
LONGEST_S = 3600.0
LINES = 8
Ended = Callable[[str, Reduction], None]


class Reducing:
    """`place` gives a run's folder, `is_live` whether it still runs; `ended` is told each end."""

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
        """End what is under way; it is begun anew when it is asked for again."""
        tasks = list(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def state(self, id: str) -> Reduction:
        """How far it is, and which tables are there."""
        tables = reduced_names(self._place(id))
        known = self._known.get(id) or Reduction(state="done" if tables else "none")
        return known.model_copy(update={"tables": tables})

    def start(self, id: str) -> Reduction:
        """Begin, where it is not under way; raises Refusal (409) while the run goes on."""
        folder = self._place(id)
        if self._is_live(id):
            raise Refusal(
                409, "LIVE", f"{id} is running", "its spectra are reduced when it is over"
            )
        if id not in self._tasks:
            self._known[id] = Reduction(state="waiting", text="another run is reduced first")
            task = asyncio.create_task(self._work(id, folder))
            self._tasks[id] = task
            task.add_done_callback(lambda _: self._tasks.pop(id, None))
        return self.state(id)

    async def _work(self, id: str, folder: Path) -> None:
        async with self._turn:
            said = ""
            for step in STEPS:
                self._known[id] = Reduction(state="working", text=f"labrun {step} {id}")
                good, said = await _do(step, folder)
                if not good:
                    self._end(id, Reduction(state="failed", text=said))
                    return
            self._end(id, Reduction(state="done", text=said))

    def _end(self, id: str, told: Reduction) -> None:
        self._known[id] = told
        self._ended(id, told)


async def _do(step: str, folder: Path) -> tuple[bool, str]:
    """Whether a command succeeded, and its last words; one core is left to the bench."""
    more = ["--jobs", str(max(1, (os.cpu_count() or 2) - 1))] if step == "reduce" else []
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-P", "-m", "labrun.engine", step, str(folder), *more,
        stdin=asyncio.subprocess.DEVNULL, stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT, start_new_session=sys.platform != "win32",
        env={**os.environ, "COLUMNS": "200", "NO_COLOR": "1"},
    )  # fmt: skip
    try:
        async with asyncio.timeout(LONGEST_S):
            told, _ = await process.communicate()
    except TimeoutError:
        return False, f"labrun {step} took longer than {LONGEST_S / 3600:g} h and was ended"
    finally:
        if process.returncode is None:
            _kill(process)
            await process.wait()
    lines = told.decode(errors="replace").replace("labrun: ", "").strip().splitlines()
    good = process.returncode == 0
    if good:  # the files that were made are told as tables
        lines = [line for line in lines if not line.startswith("made ")][:LINES]
    return good, "\n".join(lines[-LINES:]).replace(f"{folder}", folder.name)


def _kill(process: asyncio.subprocess.Process) -> None:
    """The command with the processes that it has started itself."""
    import signal

    if sys.platform == "win32":
        process.kill()
    else:
        os.killpg(process.pid, signal.SIGKILL)
