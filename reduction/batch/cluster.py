"""The workers of a dask cluster: spectra are sent to them as bytes, so no shared disk is needed."""

import asyncio
import logging
import queue
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress
from typing import Any

from ...system.extras import not_installed
from .executor import Answer, Chunk, ExecutorFault, ExecutorUnreachable
from .settings import Settings
from .versions import versions
from .work import Done, failed, load, reduce_bytes

REACH_S = 6.0  # for the scheduler to answer; importing dask takes a second or two more
LOST_S = 10.0  # without the scheduler, after which waiting ends
AHEAD = 2  # chunks per worker: one being reduced, one in transit


class Cluster:
    """All workers of the scheduler at `address`. Raises ExecutorUnreachable with a sentence."""

    def __init__(self, address: str, settings: Settings, reach_s: float = REACH_S) -> None:
        try:
            import distributed
        except ImportError as fault:
            raise ExecutorFault(f"--dask: {not_installed(fault) or fault}") from None
        _be_quiet()
        self.address = address
        self.settings = settings
        _check_that_it_answers(address, reach_s)
        self.client: Any = distributed.Client(address, timeout=reach_s, set_as_default=False)
        self.differing = self._look_at_workers(reach_s)
        self.room = AHEAD * max(sum(self.client.nthreads().values()), 1)
        self.ready: queue.SimpleQueue[tuple[int, Any]] = queue.SimpleQueue()
        self.futures: dict[int, Any] = {}
        self.seen = time.monotonic()

    def start(self, number: int, chunk: Chunk) -> None:
        """Send the chunk's bytes; a file that cannot be read here becomes a row and is not sent."""
        held = [(source.name, load(source.path)) for source in chunk]
        future = self.client.submit(reduce_held, held, self.settings, pure=False)
        self.futures[number] = future
        future.add_done_callback(lambda done: self.ready.put((number, done)))

    def answers(self, wait_s: float) -> list[Answer]:
        """Answers within that time. Raises ExecutorFault when the scheduler is gone for good."""
        try:
            number, future = self.ready.get(timeout=wait_s)
        except queue.Empty:
            self._still_there()
            return []
        self.futures.pop(number, None)
        fault = None
        try:
            if future.status == "finished":
                return [Answer(number, future.result())]
            fault = future.exception() if future.status == "error" else None
        except (OSError, CancelledError):
            pass  # the scheduler went away after the work ended, before its result was fetched
        if fault is None:  # cancelled or lost: the scheduler is gone
            raise ExecutorFault(f"lost the dask scheduler at {self.address}")
        return [Answer(number, lost=f"the cluster did not reduce it: {_words(fault)}")]

    def close(self) -> None:
        """Cancel what is under way and disconnect; the cluster keeps running."""
        with suppress(Exception):  # there may be no scheduler any more
            self.client.cancel(list(self.futures.values()), force=True, asynchronous=False)
        with suppress(Exception):  # there may be no scheduler any more
            self.client.close(timeout=1)

    def _still_there(self) -> None:
        if self.client.status == "running":
            self.seen = time.monotonic()
        elif time.monotonic() - self.seen > LOST_S:
            raise ExecutorFault(f"lost the dask scheduler at {self.address}")

    def _look_at_workers(self, reach_s: float) -> str:
        """Wait for a worker; a sentence if its versions differ from those here, else empty."""
        try:
            self.client.wait_for_workers(1, timeout=reach_s)
            theirs: Any = self.client.run(versions)
        except TimeoutError:
            self.close()
            raise ExecutorUnreachable(
                f"the dask scheduler at {self.address} has no worker; start one with: "
                f"dask worker {self.address}"
            ) from None
        except Exception as fault:  # raised by a worker that cannot import labrun
            self.close()
            raise ExecutorFault(
                f"a worker of {self.address} cannot use labrun ({_words(fault)}); "
                "install this version of it there"
            ) from fault
        return differing(theirs)


def reduce_held(held: Sequence[tuple[str, bytes | str]], settings: Settings) -> list[Done]:
    """Reduce spectra received as bytes; text is why there are none. Runs on a worker."""
    return [
        failed(name, raw) if isinstance(raw, str) else reduce_bytes(name, raw, settings)
        for name, raw in held
    ]


def _check_that_it_answers(address: str, reach_s: float) -> None:
    """Probe the address before making a client: one that finds nobody takes 20 s to close."""
    from distributed.core import rpc

    async def ask() -> str:
        async with asyncio.timeout(reach_s), rpc(address, timeout=reach_s) as there:
            told: Any = await there.identity()
            return str(told["type"])

    try:
        what = asyncio.run(ask())
    except TimeoutError:
        fault = f"no answer within {reach_s:g} s"
    except ValueError as wrong:
        fault = _words(wrong)
    except (Exception, asyncio.CancelledError):  # something answers, but not in dask's protocol
        fault = "something else answers"
    else:
        if what == "Scheduler":
            return
        fault = f"a {what} answers"
    raise ExecutorUnreachable(
        f"no dask scheduler answers at {address} ({fault}); is `dask scheduler` running there?"
    )


def _be_quiet() -> None:
    """Silence dask's tracebacks of what is reported here in a sentence."""
    for name in ("distributed", *logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)


def differing(theirs: Mapping[str, Mapping[str, str]]) -> str:
    """A sentence on the first worker whose versions differ from those here; empty if none do."""
    here = versions()
    for address, there in theirs.items():
        for name, version in here.items():
            if there.get(name) != version:
                return (
                    f"{address} has {name} {there.get(name)} and this machine {version}: "
                    "the last digits of tables may differ"
                )
    return ""


def _words(fault: BaseException) -> str:
    words = " ".join(str(fault).split())
    return words[:200] or type(fault).__name__
