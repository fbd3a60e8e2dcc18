"""Runs listed and found again among 10,000, beside a bare SELECT of the rows.

One real run is made and its folder repeated with other names, times, samples and parameters. Then, in
turns: `find_runs`, which first looks whether a folder has changed, and a SELECT on the same file.
Run: python benchmarks/index.py [--runs N]
"""

import argparse
import json
import sqlite3
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import labrun
from labrun.engine.index.entry import COLUMNS
from labrun.engine.index.index import FILE, find_runs

TIMES = 9
PROTOCOL = """
labrun: 1
name: map
params: {sample: {type: string, default: K17}, pitch: {type: quantity, unit: mm, default: 0.2 mm}}
devices: {}
steps: [{log: "${{ params.sample }}"}]
outputs: {pitch: "${{ params.pitch }}"}
"""
SEARCHES = ("", "map", "sample:K7", "pitch<0.2mm", "since:2026-06-01 succeeded")
BEGAN = datetime(2026, 1, 1, tzinfo=UTC)


def many(folder: Path, count: int) -> Path:
    """`count` folders of runs, and nothing else."""
    protocol = folder / "map.yaml"
    protocol.write_text(PROTOCOL)
    one = Path(labrun.run(protocol, runs=folder / "first").folder)
    summary = json.loads((one / "summary.json").read_text())
    files = {
        path.name: path.read_bytes()
        for path in one.iterdir()
        if path.suffix in (".yaml", ".json", ".jsonl") and path.name != "summary.json"
    }
    runs = folder / "runs"
    for n in range(count):
        began = BEGAN + timedelta(minutes=30 * n)
        place = runs / f"{began:%Y-%m-%d}_map_{n:05d}"
        place.mkdir(parents=True)
        for name, data in files.items():
            (place / name).write_bytes(data)
        pitch = {"$quantity": [0.1 + 0.01 * (n % 30), "mm"]}
        told = summary | {
            "run": place.name, "began": began.isoformat(), "ended": began.isoformat(),
            "params": {"sample": f"K{n % 100}", "pitch": pitch}, "samples": [f"K{n % 100}"],
        }  # fmt: skip
        (place / "summary.json").write_text(json.dumps(told))
    return runs


def took_ms(do: Callable[[], object]) -> float:
    """Milliseconds."""
    began = time.perf_counter()
    do()
    return 1000 * (time.perf_counter() - began)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=10_000)
    count = parser.parse_args().runs
    names = ", ".join(f'"{name}"' for name in COLUMNS)
    with tempfile.TemporaryDirectory() as name:
        runs = many(Path(name), count)
        print(
            f"{count:,} runs read for the first time: {took_ms(lambda: find_runs(runs)) / 1000:.1f} s"
        )
        with closing(sqlite3.connect(runs / FILE)) as base:
            query = f"SELECT {names} FROM runs ORDER BY began, run"
            worst = max(beside(runs, base, query, text) for text in SEARCHES)
        print(f"worst ratio {worst:.1f}")


def beside(runs: Path, base: sqlite3.Connection, query: str, text: str) -> float:
    """How many times as long a search takes as the SELECT of all rows that it looks through."""
    ours, bare = [], []
    for _ in range(TIMES):
        ours.append(took_ms(lambda: find_runs(runs, text)))
        bare.append(took_ms(lambda: base.execute(query).fetchall()))
    ratio = statistics.median(ours) / statistics.median(bare)
    print(
        f"{text or 'all'!r}: {len(find_runs(runs, text)):,} found in {statistics.median(ours):.0f} ms, "
        f"{ratio:.1f} times the bare SELECT ({statistics.median(bare):.1f} ms)"
    )
    return ratio


if __name__ == "__main__":
    sys.exit(main())
