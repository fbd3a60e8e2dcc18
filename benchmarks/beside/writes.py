"""What the durable writes of one action take by themselves: no engine, no wire, one process."""

import os
import time
from pathlib import Path

from labrun.drivers.server.ledger import Ledger
from labrun.schemas.messages import Goal

RECORDS = b"x" * 700
"""As long as what the journal keeps of an action of this benchmark."""


def writes_alone(folder: Path, count: int) -> list[float]:
    """Seconds of two commits of a ledger and one append to a journal, all three on disk."""
    folder.mkdir()
    ledger = Ledger(folder / "ledger.sqlite")
    times = []
    try:
        with (folder / "journal").open("ab", buffering=0) as journal:
            for i in range(count):
                goal = Goal(id=f"run/main/{i}", device="d", boot=ledger.boot, epoch=1, action="a")
                began = time.perf_counter()
                ledger.admit(goal, "EXECUTING")
                ledger.end(goal.id, "SUCCEEDED", {})
                journal.write(RECORDS)
                os.fdatasync(journal.fileno())
                times.append(time.perf_counter() - began)
    finally:
        ledger.close()
    return times
