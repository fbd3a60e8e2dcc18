"""Wait until a file that was written a moment ago has stopped growing."""

import time
from pathlib import Path

RECENT_S = 2.0  # a file older than this is complete
LOOK_S = 0.1
STILL_LOOKS = 2  # looks in a row at which the size was the same
LONGEST_S = 5.0


def settle(path: Path, longest_s: float = LONGEST_S) -> bool:
    """Whether the file's size stands still, at once for an old one. Raises OSError if it is gone."""
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
