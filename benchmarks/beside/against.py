"""This tree's engine beside another checkout of labrun, turn by turn, so that a busy machine meets both.

A round is the other tree, this one, the other again: its ratio is that of this tree's median to the
geometric mean of the other's two, in which a steady drift of the machine cancels; the two of the
other, divided, are the control, which would be 1 on a quiet machine.
"""

import contextlib
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).parent.parent
TURN_LIMIT_S = 600
Interval = tuple[float, float, float]


def against(other: Path, rounds: int, actions: int, place: Path) -> dict[str, Interval]:
    """Ratio and control, each the median over all rounds with the ends of its 95 % interval."""
    ratios, controls = [], []
    with _importable(other) as theirs, _importable(HERE.parent) as ours:
        for _ in range(rounds):
            before, this, after = (_turn(t, actions, place) for t in (theirs, ours, theirs))
            ratios.append(this / math.sqrt(before * after))
            controls.append(before / after)
    return {"this tree / the other": median_of(ratios), "the other / itself": median_of(controls)}


def median_of(values: list[float]) -> Interval:
    """Median, and the order statistics between which it lies in 95 of 100 samples, whatever their law."""
    ordered, n = sorted(values), len(values)
    below = max(0, math.floor(n / 2 - 0.98 * math.sqrt(n)))
    return statistics.median(ordered), ordered[below], ordered[n - 1 - below]


@contextlib.contextmanager
def _importable(tree: Path) -> Iterator[Path]:
    """A folder from which `import labrun` finds this tree, whatever is installed."""
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "labrun").symlink_to(tree.resolve(), target_is_directory=True)
        yield Path(name)


def _turn(path: Path, actions: int, place: Path) -> float:
    """Median seconds of an action, engine and device server both of the tree in this path."""
    command = [sys.executable, "-P", str(HERE / "dispatch.py"), "--turn", str(place)]
    done = subprocess.run(
        [*command, "--goals", str(actions)], capture_output=True, text=True, timeout=TURN_LIMIT_S,
        env={**os.environ, "PYTHONPATH": str(path)}, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    if done.returncode:
        raise SystemExit(
            f"a turn with {(path / 'labrun').readlink()} failed:\n{done.stderr[-2000:]}"
        )
    said = json.loads(done.stdout.splitlines()[-1])
    if Path(said["labrun"]).resolve() != (path / "labrun").resolve():
        raise SystemExit(f"the turn ran {said['labrun']}, not {(path / 'labrun').readlink()}")
    return said["median_s"]
