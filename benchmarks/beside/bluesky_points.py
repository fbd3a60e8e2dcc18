"""One bluesky `grid_scan` over ophyd's simulated devices: seconds from point to point, as one JSON line.

Nothing is kept: no document is written anywhere. Messages and device actions a point are counted in
a separate scan, so that the counting is not timed.
Run with an interpreter that has bluesky and ophyd: python bluesky_points.py POINTS
"""

import itertools
import json
import sys
import time
from collections import Counter
from importlib.metadata import version

COLUMNS = 10
WARM_UP = 10
ACTIONS = ("set", "trigger")
"""Messages that make a device do something; `read`, `save`, `wait` and the like do not."""


def measure(points: int) -> dict:
    """Run the scans; return the time of a point and what it consisted of."""
    from bluesky import RunEngine
    from bluesky.plans import grid_scan
    from ophyd.sim import det, motor1, motor2

    engine = RunEngine({})

    def scan(rows: int):
        return grid_scan([det], motor1, 0, 1, rows, motor2, 0, 1, COLUMNS, snake_axes=True)

    at: list[float] = []
    told = engine.subscribe(lambda name, document: at.append(time.perf_counter()), "event")
    engine(scan(-(-(WARM_UP + points + 1) // COLUMNS)))
    engine.unsubscribe(told)

    messages: Counter[str] = Counter()
    engine.msg_hook = lambda message: messages.update([message.command])
    engine(scan(COLUMNS))
    counted = COLUMNS * COLUMNS
    return {
        "seconds": [b - a for a, b in itertools.pairwise(at)][WARM_UP:][:points],
        "messages": sum(messages.values()) / counted,
        "actions": sum(messages[command] for command in ACTIONS) / counted,
        "versions": f"bluesky {version('bluesky')}, ophyd {version('ophyd')}",
    }


def main() -> None:
    """Print what was measured, or what is missing."""
    try:
        said = measure(int(sys.argv[1]))
    except ImportError as fault:
        said = {"missing": str(fault)}
    print(json.dumps(said))


if __name__ == "__main__":
    main()
