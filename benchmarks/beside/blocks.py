"""Actions in blocks, each begun by a line on stdin: one JSON line of what it took, once it is over.

Three times in seconds: by the clock, and of a processor in the engine and in the device server (Linux).
Run in `benchmarks`: python -m beside.blocks FOLDER BLOCKS
"""

import contextlib
import io
import json
import os
import sys
import time
from pathlib import Path

from beside.servers import serving
from dispatch import engine_times

from labrun.drivers.client.client import DeviceClient

ACTIONS = 25
"""Of a block: so short that a busy machine is the same for two blocks in turn."""


def run(folder: Path, blocks: int) -> None:
    """Begin, say which labrun this is of, and wait before each block."""
    out, follow = sys.stdout, DeviceClient.follow
    number, began = 0, []

    async def in_blocks(self, goal, *more, **named):
        nonlocal number
        if number % ACTIONS == 0:
            took = [now - then for now, then in zip(times(), began, strict=True)] if began else of
            print(json.dumps(took), file=out, flush=True)
            sys.stdin.readline()
            began[:] = times()
        number += 1
        return await follow(self, goal, *more, **named)

    with serving(folder, synced=True) as server, contextlib.redirect_stdout(io.StringIO()):

        def times() -> list[float]:
            return [time.perf_counter(), processor_s(os.getpid()), processor_s(server.pid)]

        of = str(Path(sys.modules["labrun"].__file__ or "").parent)
        DeviceClient.follow = in_blocks
        engine_times(folder, ACTIONS * blocks + 1)


def processor_s(pid: int) -> float:
    """The processor time of a process with its threads, to the nanosecond."""
    tasks = Path(f"/proc/{pid}/task").glob("*/schedstat")
    return sum(int(task.read_text(encoding="ascii").split()[0]) for task in tasks) / 1e9


if __name__ == "__main__":
    run(Path(sys.argv[1]), int(sys.argv[2]))
