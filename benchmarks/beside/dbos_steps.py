"""One DBOS workflow of trivial steps on SQLite: seconds from step to step, as one JSON line.

The settings are DBOS's own; how durable they are is asked of a connection of its own engine.
Run with an interpreter that has dbos: python dbos_steps.py STEPS FOLDER
"""

import itertools
import json
import sys
import time
from importlib.metadata import version
from pathlib import Path

WARM_UP = 10
SYNCHRONOUS = ("OFF", "NORMAL", "FULL", "EXTRA")
"""SQLite's numbers for `PRAGMA synchronous`, in order."""


def measure(steps: int, folder: Path) -> dict:
    """Run the workflow; return the time of a step and its durability settings."""
    from dbos import DBOS, DBOSConfig

    config = DBOSConfig(
        name="steps",
        system_database_url=f"sqlite:///{folder / 'dbos.sqlite'}",
        log_level="ERROR",
        run_admin_server=False,
    )
    dbos = DBOS(config=config)

    @DBOS.step()
    def nothing(i: int) -> dict:
        return {}

    @DBOS.workflow()
    def work() -> list[float]:
        at = []
        for i in range(WARM_UP + steps + 1):
            nothing(i)
            at.append(time.perf_counter())
        return at

    DBOS.launch()
    try:
        at = work()
        kept = durability(dbos)
    finally:
        DBOS.destroy()
    return {
        "seconds": [b - a for a, b in itertools.pairwise(at)][WARM_UP:],
        "kept": kept,
        "versions": f"dbos {version('dbos')}",
    }


def durability(dbos) -> str:
    """What SQLite was told about safety, by the connections that the workflow used."""
    # DBOS has no public API for it, and another connection would report its own settings.
    with dbos._sys_db.engine.connect() as disk:
        mode = disk.exec_driver_sql("PRAGMA journal_mode").scalar_one()
        level = disk.exec_driver_sql("PRAGMA synchronous").scalar_one()
    return f"journal_mode {str(mode).upper()}, synchronous {SYNCHRONOUS[level]}"


def main() -> None:
    """Print what was measured, or what is missing."""
    try:
        said = measure(int(sys.argv[1]), Path(sys.argv[2]))
    except ImportError as fault:
        said = {"missing": str(fault)}
    print(json.dumps(said))


if __name__ == "__main__":
    main()
