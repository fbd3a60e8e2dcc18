"""This tree's engine beside another checkout of labrun, block by block, so that a busy machine meets both.

In a round both are alive at once, the other twice; they do blocks of 25 actions in turns. The ratio is that
to the geometric mean of the other's two; these two, divided, are the control, which would be 1 on a quiet
machine. Each round starts them anew: how a process happens to lie in memory makes some percent.
"""

import contextlib
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

HERE = Path(__file__).parent.parent
BLOCKS = 24
"""Of a round; each of 25 actions."""
LEFT_OUT = 2
"""Blocks at the start: imports and first-time caches are not what is measured."""
TIMES = ("clock", "engine", "server")
"""By the clock, and of a processor."""
Interval = tuple[float, float, float]
Times = list[float]


def against(other: Path, rounds: int, place: Path) -> dict[str, Interval]:
    """Ratios and controls, each the median over all blocks with the ends of its 95 % interval."""
    took = [blocks for n in range(rounds) for blocks in _round(other, place / str(n))]
    found = {}
    for i, what in enumerate(TIMES):
        ratios = [ours[i] / math.sqrt(a[i] * b[i]) for a, ours, b in took]
        found[f"this tree / the other, {what}"] = median_of(ratios)
        found[f"  the other / itself, {what}"] = median_of([b[i] / a[i] for a, _, b in took])
    return found


def _round(other: Path, place: Path) -> list[list[Times]]:
    """What each block took: of the other, of this tree, of the other again."""
    place.mkdir()
    with contextlib.ExitStack() as alive:
        trees = enumerate((other, HERE.parent, other))
        sides = [alive.enter_context(_alive(tree, place / str(n))) for n, tree in trees]
        took = []
        for n in range(LEFT_OUT + BLOCKS):
            block: dict[int, Times] = {}
            # Whoever comes twice in a row finds its caches warm: each is that as often.
            for k in (0, 1, 2) if n // 3 % 2 else (2, 1, 0):
                side = (k + n) % 3
                block[side] = sides[side]()
            took.append([block[side] for side in range(3)])
    return took[LEFT_OUT:]


def median_of(values: list[float]) -> Interval:
    """Median, and the order statistics between which it lies in 95 of 100 samples, whatever their law."""
    ordered, n = sorted(values), len(values)
    below = max(0, math.floor(n / 2 - 0.98 * math.sqrt(n)))
    return statistics.median(ordered), ordered[below], ordered[n - 1 - below]


@contextlib.contextmanager
def _alive(tree: Path, place: Path) -> Iterator[Callable[[], Times]]:
    """Engine and device server of this tree; call it for what the next block takes."""
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "labrun").symlink_to(tree.resolve(), target_is_directory=True)
        with subprocess.Popen(
            [sys.executable, "-m", "beside.blocks", str(place), str(LEFT_OUT + BLOCKS)], cwd=HERE, text=True,
            env={**os.environ, "PYTHONPATH": name, "PYTHONHASHSEED": "0"},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        ) as process:  # fmt: skip
            assert process.stdin is not None
            assert process.stdout is not None
            told, hear = process.stdin, process.stdout

            def block() -> Times:
                print(file=told, flush=True)
                return json.loads(_line(hear.readline(), tree))

            of = Path(json.loads(_line(hear.readline(), tree)))
            if of.resolve() != tree.resolve():
                raise SystemExit(f"this ran {of}, not {tree}")
            yield block


def _line(line: str, tree: Path) -> str:
    if not line:
        raise SystemExit(f"the engine of {tree} has failed; it has said why")
    return line
