"""Print how fast a folder of spectra is reduced, from files to tables, compared with numpy reading it.

    python benchmarks/batch.py                     1,071 spectra of the simulated core, all cores
    python benchmarks/batch.py --spectra 100 --jobs 1
    python benchmarks/batch.py --folder spectra    spectra of your own

`labrun reduce` runs as a user runs it: a process that starts, finds the files, reduces them, writes
eight tables and ends. For comparison `numpy.loadtxt` only reads the same files. Memory is the
largest sum over all processes of the command, sampled ten times a second.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

CHANNELS = 22_800
SIDE = 21  # points of the map side by side: 21 x 51 = 1,071
PITCH_MM = 0.2
LOADED = 40  # files that numpy reads: enough to know the time of one
LOOK_S = 0.1
TABLES = ("files", "peaks", "elements", "plasma")


def make_spectra(folder: Path, n: int) -> None:
    """Shots at the simulated core on the grid of `pegmatite_map.yaml`."""
    from labrun.drivers.simulated.twins.shot import ShotMaker

    maker = ShotMaker(core=1, seed=3)
    for k in range(n):
        ix, iy = k % SIDE, k // SIDE
        shot = {"n": k, "x": ix * PITCH_MM, "y": iy * PITCH_MM, "focus": 1.0}
        (folder / f"core_{ix}_{iy}.csv").write_bytes(maker.csv(shot))


def reduce(folder: Path, out: Path, jobs: int) -> tuple[float, float, float]:
    """Wall-clock seconds, processor seconds, and peak memory in megabytes."""
    command = [
        sys.executable, "-m", "labrun.engine", "reduce", str(folder), "-o", str(out),
        "--jobs", str(jobs), "--no-figures",
    ]  # fmt: skip
    before, began = os.times(), time.perf_counter()
    run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    most = 0.0
    while run.poll() is None:
        most = max(most, held_mb(run.pid))
        time.sleep(LOOK_S)
    assert run.stderr is not None
    told = run.stderr.read()
    if run.returncode:
        sys.exit(told)
    took, after = time.perf_counter() - began, os.times()
    children = (after.children_user - before.children_user) + (
        after.children_system - before.children_system
    )
    return took, children, most


def held_mb(pid: int) -> float:
    """Memory of a process and its children; pages that they share are counted in part (PSS)."""
    family, total = [pid], 0.0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
        except (OSError, ValueError, IndexError):
            continue
        if parent == pid:
            family.append(int(stat.parent.name))
    for one in family:
        try:
            for line in Path(f"/proc/{one}/smaps_rollup").read_text().splitlines():
                if line.startswith("Pss:"):
                    total += int(line.split()[1]) / 1024
        except (OSError, ValueError):
            continue
    return total


def loadtxt_s(folder: Path) -> float:
    """Seconds that numpy needs to read one of the files."""
    files = sorted(folder.glob("*.csv"))[:LOADED]
    began = time.perf_counter()
    for file in files:
        np.loadtxt(file, delimiter=",", skiprows=1)
    return (time.perf_counter() - began) / len(files)


def same(one: Path, other: Path) -> bool:
    names = [f"{table}{suffix}" for table in TABLES for suffix in (".csv", ".parquet")]
    return all((one / name).read_bytes() == (other / name).read_bytes() for name in names)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spectra", type=int, default=1071)
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--folder", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = given.folder or Path(place) / "spectra"
        if given.folder is None:
            folder.mkdir()
            make_spectra(folder, given.spectra)
        n = len(list(folder.glob("*.csv")))
        size_mb = sum(path.stat().st_size for path in folder.glob("*.csv")) / 1e6
        few = Path(place) / "one"
        few.mkdir()
        (few / "first.csv").write_bytes(next(folder.glob("*.csv")).read_bytes())
        start_s, _, _ = reduce(few, Path(place) / "start", 1)  # kernels are compiled after this
        start_s, _, _ = reduce(few, Path(place) / "start", 1)
        print(f"{n} spectra, {size_mb:.0f} MB; load {os.getloadavg()[0]:.1f} before")
        print(f"one spectrum, start and all        {start_s:8.2f} s")
        took, processor, most = reduce(folder, Path(place) / "all", given.jobs)
        print(
            f"all of them, {given.jobs} processes          {took:8.2f} s   {n / took:6.0f} spectra/s"
        )
        print(
            f"  of processors                    {processor:8.2f} s   {n / processor:6.0f} spectra/s/core"
        )
        print(f"  memory, all processes            {most:8.0f} MB")
        alone, _, _ = reduce(folder, Path(place) / "alone", 1)
        print(f"all of them, 1 process             {alone:8.2f} s   {n / alone:6.0f} spectra/s")
        read = loadtxt_s(folder) * n
        print(f"numpy.loadtxt of them, 1 process   {read:8.2f} s   {n / read:6.0f} spectra/s")
        print(f"  reducing / only reading          {alone / read:8.2f}")
        print(
            f"tables the same for 1 and {given.jobs}: {same(Path(place) / 'all', Path(place) / 'alone')}"
        )
        print(f"load {os.getloadavg()[0]:.1f} after")


if __name__ == "__main__":
    main()
