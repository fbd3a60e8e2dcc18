"""Wait until a recently written file has stopped growing."""

import time
from pathlib import Path

RECENT_S = 2.0  # a file older than this is complete
LOOK_S = 0.1
STILL_LOOKS = 2  # consecutive checks with the same size
LONGEST_S = 5.0


def wait_until_finished(path: Path, longest_s: float = LONGEST_S) -> bool:
    """Whether the file's size is stable, immediate for an old file. Raises OSError if it is gone."""
    ends = time.monotonic() + longest_s
    before = path.stat()
    if not 0 <= time.time() - before.st_mtime < RECENT_S:
        return True
    size, still = before.st_size, 0
    while still < STILL_LOOKS:
        if time.monotonic() > ends:
            return False
        time.sleep(LOOK_S)
        now = path.stat().st_size
        still = still + 1 if now == size else 0
        size = now
    return True
