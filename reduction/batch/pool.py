"""The processes of this machine: started when there is work, replaced when they die.

Not `concurrent.futures`: when one of its processes is killed the whole pool breaks, and the spectrum
that caused it is unknown. Here each process has a separate pipe, which also ends it when this
process is gone for whatever reason.
"""

import multiprocessing as mp
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any

from .executor import Answer, Chunk, ExecutorFault
from .settings import Settings
from .worker import COMPILING, UP, main

CHUNK_S = 300.0  # after which a chunk is abandoned, by a process that is ready
COMPILING_S = 900.0  # more for one that compiles: half a minute of an idle core
END_S = 1.0
MOST_STILLBORN = 3  # consecutive processes that end before they are ready
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
# Arrays of a spectrum are as large as what glibc gives back to the system each time: 450 page faults a
# spectrum. The first alone makes it 1,900, since it stops the second from growing.
KEPT_MEMORY = ("MALLOC_TRIM_THRESHOLD_", "MALLOC_MMAP_THRESHOLD_")
KEPT_BYTES = 32 << 20
OF_WORKERS = {**dict.fromkeys(ONE_THREAD, "1"), **dict.fromkeys(KEPT_MEMORY, str(KEPT_BYTES))}


@dataclass(slots=True, eq=False)
class _Worker:
    process: SpawnProcess
    link: Connection
    up: bool = False
    number: int | None = None  # of the chunk that it has
    ends: float = 0.0
    compiling: bool = False  # or waits for what another compiles


class Pool:
    """Up to `jobs` processes. told: called once, when a worker starts compiling its kernels."""

    def __init__(
        self, jobs: int, settings: Settings, told: Callable[[], None], chunk_s: float = CHUNK_S
    ) -> None:
        self.room = jobs
        self.settings = settings
        self.told: Callable[[], None] | None = told
        self.chunk_s = chunk_s
        self.workers: list[_Worker] = []
        self.stillborn = 0

    def call_up(self) -> None:
        """Start all processes now: they take a second to be ready."""
        while len(self.workers) < self.room:
            self._new()

    def start(self, number: int, chunk: Chunk) -> None:
        """Give the chunk to an idle process; there is one as long as `room` is respected."""
        worker = next((w for w in self.workers if w.number is None), None) or self._new()
        worker.number, worker.ends = number, time.monotonic() + self.chunk_s
        # A worker that has just died is noticed when answers are collected.
        with suppress(OSError):
            worker.link.send((number, [(source.name, source.path) for source in chunk]))

    def answers(self, wait_s: float) -> list[Answer]:
        """Answers within that time. Raises ExecutorFault when no process starts at all."""
        owner: dict[Any, _Worker] = {w.process.sentinel: w for w in self.workers}
        owner |= {w.link: w for w in self.workers}
        found = []
        for ready in wait(list(owner), wait_s):
            worker = owner[ready]
            if worker not in self.workers:
                continue  # already reported by its other handle
            found += self._heard(worker) if ready is worker.link else self._ended(worker)
        late = [w for w in self.workers if w.number is not None and time.monotonic() > w.ends]
        for worker in late:
            worker.process.kill()
            found += self._buried(worker, f"it took longer than {self.chunk_s:g} s")
        return found

    def close(self) -> None:
        """End all processes, at once."""
        for worker in self.workers:
            worker.link.close()
            worker.process.terminate()
        for worker in self.workers:
            worker.process.join(END_S)
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join(END_S)
        self.workers.clear()

    def _new(self) -> _Worker:
        context = mp.get_context("spawn")
        here, there = context.Pipe()
        process = context.Process(target=main, args=(there, self.settings), daemon=True)
        with _deaf_and_alone():
            process.start()
        there.close()  # the only other holder: the pipe ends with the process
        worker = _Worker(process, here)
        self.workers.append(worker)
        return worker

    def _heard(self, worker: _Worker) -> list[Answer]:
        try:
            what, *rest = worker.link.recv()
        except (EOFError, OSError):
            return self._buried(worker)
        if what == UP:
            worker.up, self.stillborn = True, 0
            worker.ends = max(worker.ends, time.monotonic() + self.chunk_s)
            return []
        if what == COMPILING:
            for one in [w for w in self.workers if not w.compiling]:
                one.compiling, one.ends = True, one.ends + COMPILING_S
            if self.told is not None:
                self.told()
            self.told = None
            return []
        number, done = rest
        worker.number = None
        return [Answer(number, done)]

    def _ended(self, worker: _Worker) -> list[Answer]:
        said = []
        while worker in self.workers and worker.link.poll():  # its last messages
            said += self._heard(worker)
        return said + self._buried(worker) if worker in self.workers else said

    def _buried(self, worker: _Worker, why: str = "") -> list[Answer]:
        self.workers.remove(worker)
        worker.link.close()
        worker.process.join(END_S)
        if not worker.up:
            self._count_stillborn(worker.process.exitcode)
        if worker.number is None:
            return []
        why = why or f"the process that reduced it {how_it_ended(worker.process.exitcode)}"
        return [Answer(worker.number, lost=why)]

    def _count_stillborn(self, exitcode: int | None) -> None:
        self.stillborn += 1
        if self.stillborn >= MOST_STILLBORN:
            raise ExecutorFault(
                f"no reduction process starts, {self.stillborn} times in a row; the last "
                f"{how_it_ended(exitcode)}; is the installation complete, and is there enough memory?"
            )


def how_it_ended(exitcode: int | None) -> str:
    """How a process ended, as the end of a sentence."""
    if exitcode is None:
        return "did not end"
    if exitcode >= 0:
        return f"ended with status {exitcode}"
    try:
        name = signal.Signals(-exitcode).name
    except ValueError:
        name = f"signal {-exitcode}"
    return f"was killed by {name}" + (" (out of memory?)" if name == "SIGKILL" else "")


@contextmanager
def _deaf_and_alone() -> Iterator[None]:
    """Processes started here ignore Ctrl-C, even while importing, have one thread, and keep memory."""
    before = {name: os.environ.get(name) for name in OF_WORKERS}
    os.environ.update(OF_WORKERS)
    try:
        hears = signal.signal(signal.SIGINT, signal.SIG_IGN)
    except ValueError:  # not the main thread: it gets no keyboard interrupt
        hears = None
    try:
        yield
    finally:
        if hears is not None:
            signal.signal(signal.SIGINT, hears)
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0)) or 1
    return os.cpu_count() or 1
