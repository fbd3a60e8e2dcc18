"""The process beside a run: `python -m labrun.engine.runner.draw_live FOLDER SECONDS`.

It ends when its input is closed: the engine has closed it, or is gone.
"""

import os
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from importlib.metadata import entry_points
from pathlib import Path

from ...system.files import put, remove

GROUP = "labrun.live"
NICE = 10
ROWS = "data*.csv"
Maker = Callable[[Path], dict[str, bytes]]
writing = threading.Lock()


def main() -> None:
    """Draw whenever the rows have changed; print each figure's name once, on stdout."""
    folder, every_s = Path(sys.argv[1]), float(sys.argv[2])
    threading.Thread(target=_end_with_input, daemon=True).start()
    if hasattr(os, "nice"):
        os.nice(NICE)
    makers = [point.load() for point in sorted(entry_points(group=GROUP), key=lambda p: p.name)]
    drawn = 0
    told: set[str] = set()
    there: set[str] = set()
    while True:
        changed = _changed(folder)
        if changed != drawn:
            drawn = changed
            names = set(draw(folder, makers))
            forget(folder, there - names)
            for name in sorted(names - told):
                print(name, flush=True)
            told |= names
            there = names
        time.sleep(every_s)


def draw(folder: Path, makers: list[Maker]) -> list[str]:
    """Call every maker and replace its former figures; returns their names."""
    names = []
    for maker in makers:
        try:
            for name, content in maker(folder).items():
                part = folder / f".{name}.part"
                with writing:
                    part.write_bytes(content)
                    put(part, folder / name)
                names.append(name)
        except Exception:  # the next rows may be better, and the report says what is wrong
            continue
    return names


def forget(folder: Path, names: set[str]) -> None:
    """Remove our figures that are no longer drawn: the first row of a map is a line."""
    for name in names:
        with suppress(PermissionError):  # on Windows a program may show it
            remove(folder / name)


def _changed(folder: Path) -> int:
    """When a row was last written; 0 if there is none."""
    return max((path.stat().st_mtime_ns for path in folder.glob(ROWS)), default=0)


def _end_with_input() -> None:
    sys.stdin.buffer.read()
    writing.acquire()  # a file that is being written is finished first
    os._exit(0)


if __name__ == "__main__":
    main()
