"""The command line, which kills itself at one write of its journal.

`python -m labrun.engine.torture.victim '{"flush": 12, "form": "torn", "servers": "..."}' run FILE`
"""

import json
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

from ..cli import main
from ..journal.journal import Journal


def die_at_write(flush: int, form: str, servers: str | None) -> None:
    """Kill this process at the journal's `flush`-th write.

    `servers` names the folder whose device servers are killed with it; `own` means the run's.
    """
    write: Callable[..., None] = Journal._write
    written = 0

    def last_write(journal: Journal, data: bytes, *, sync: bool = True) -> None:
        nonlocal written
        written += 1
        if written < flush:
            write(journal, data, sync=sync)
            return
        if form == "after":
            write(journal, data, sync=sync)
        elif form == "torn":
            os.write(journal._file, data[: max(1, len(data) // 2)])
        if servers is not None:
            folder = journal.path.parent / "servers" if servers == "own" else Path(servers)
            kill_servers(sorted(folder.glob("*/server.json")))
        os.kill(os.getpid(), signal.SIGKILL)

    setattr(Journal, "_write", last_write)  # noqa: B010 - the journal knows nothing of this


def kill_servers(present: list[Path], by: signal.Signals = signal.SIGKILL) -> int:
    """Send the device servers that announced themselves in these files a signal; returns how many."""
    killed = 0
    for path in present:
        try:
            os.kill(json.loads(path.read_bytes())["pid"], by)
            killed += 1
        except (OSError, ValueError, KeyError):
            continue  # it has ended by itself meanwhile
    return killed


if __name__ == "__main__":
    die_at_write(**json.loads(sys.argv.pop(1)))
    main()
