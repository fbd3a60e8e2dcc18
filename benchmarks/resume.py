"""Memory and time of a resume from a long journal: `python benchmarks/resume.py --records 1000000`.

The journal is that of a scan: for each point two goals with their outcomes, and its end with a row.
What is measured is what `labrun resume` does before the first goal: the chain checked, the history
read, the table of rows written again, and the past of the tree that is planted.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from labrun.engine.journal.history import read_history
from labrun.engine.journal.journal import Journal, Records, reopen
from labrun.engine.run.rows import Rows, restore_rows
from labrun.schemas import journal as j

EACH = 5
"""Records of one point."""


def write(path: Path, records: int) -> None:
    """A journal of about so many records."""
    journal = Journal(path, sync=False)
    journal.append(j.Started(run="long", protocol="long", labrun="0", python="3"))
    for index in range(records // EACH):
        for step in ("move", "shoot"):
            goal = f"long/main/scan/{index}/{step}/1"
            effect = "once" if step == "shoot" else "idempotent"
            journal.append(
                j.GoalSent(
                    id=goal, device=step, action=step, params={"x": index * 0.1, "y": 12.5},
                    effect=effect, boot="abc.def", ledger="abc", epoch=1, means="0123456789abcdef",
                )
            )  # fmt: skip
            journal.append(
                j.GoalEnded(id=goal, state="SUCCEEDED", result={"shot_id": f"{index:07}"})
            )
        row = {"x": index * 0.1, "shot": f"{index:07}"}
        journal.append(
            j.IterationEnded(
                loop="main/scan", index=index, key=str(index), fate="succeeded", row=row,
                file="data.csv",
            )
        )  # fmt: skip
        if index % 1000 == 0:
            journal.flush()
    journal.close()


def measure(path: Path) -> None:
    """Resume from it, and print what that took."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    began = time.perf_counter()
    records = Records(path)
    history = read_history(records)
    journal, records, _ = reopen(path)
    restore_rows(
        path.parent,
        records,
        {"data.csv": Rows(path.parent / "data.csv", {"x": None, "shot": None})},
    )
    past = history.past.copy()
    took = time.perf_counter() - began
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    journal.close()
    done = len(past.iterations["main/scan"])
    print(
        f"{history.last_n:,} records, {done:,} finished iterations: {took:.1f} s, "
        f"at most {peak / 1024:.0f} MB resident ({before / 1024:.0f} MB before it)"
    )


def main() -> None:
    """Write the journal, and measure in a process of its own."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--records", type=int, default=1_000_000)
    options.add_argument("--measure", type=Path)
    given = options.parse_args()
    if given.measure is not None:
        measure(given.measure)
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "journal.jsonl"
        write(path, given.records)
        print(f"a journal of {path.stat().st_size / 1e6:.0f} MB", flush=True)
        subprocess.run([sys.executable, __file__, "--measure", str(path)], check=True)


if __name__ == "__main__":
    main()
