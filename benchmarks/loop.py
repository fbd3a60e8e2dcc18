"""A loop of instant steps: time per iteration and memory, for many iterations beside 10,000.

Each count runs in a separate process, so that memory is measured separately. Run: python benchmarks/loop.py
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROTOCOL = """
labrun: 1
name: loop
steps:
  - foreach: {{i: "${{{{ range({count}) }}}}"}}
    steps:
      - set: {{last: "${{{{ i }}}}"}}
"""


def measure(count: int) -> dict[str, float]:
    """Run a loop of this many iterations here; return time and memory."""
    with tempfile.TemporaryDirectory() as folder:
        _run(10, Path(folder))  # imports and first-time caches are not what is measured
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        began = time.perf_counter()
        _run(count, Path(folder))
        took = time.perf_counter() - began
        grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    return {"count": count, "seconds": took, "grown_mb": grown / 1024}


def _run(count: int, folder: Path) -> None:
    from labrun.engine.check import check_file
    from labrun.engine.commands.run import start

    path = folder / f"loop{count}.yaml"
    path.write_text(PROTOCOL.format(count=count), encoding="utf-8")
    checked = check_file(path)
    assert checked.ok, checked.problems
    status = start(checked, folder / "runs")
    assert status == 0, status


def in_a_process(count: int) -> dict[str, float]:
    """The same in a new process."""
    command = [sys.executable, __file__, "--one", str(count)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def main() -> None:
    """Print both, and their ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--iterations", type=int, default=1_000_000)
    parser.add_argument("--one", type=int)
    said = parser.parse_args()
    if said.one:
        print(json.dumps(measure(said.one)))
        return
    small, large = in_a_process(10_000), in_a_process(said.iterations)
    print(f"{'iterations':>12} {'seconds':>9} {'us each':>9} {'memory grown':>14}")
    for row in (small, large):
        each = 1e6 * row["seconds"] / row["count"]
        print(
            f"{row['count']:>12,} {row['seconds']:>9.2f} {each:>9.1f} {row['grown_mb']:>11.1f} MB"
        )
    ratio = (large["seconds"] / large["count"]) / (small["seconds"] / small["count"])
    print(f"time per iteration, large / small: {ratio:.2f}")
    print(f"memory grown, large - small: {large['grown_mb'] - small['grown_mb']:.1f} MB")


if __name__ == "__main__":
    main()
