"""What it takes to start: the version, a check of one step, a device server, each beside bare Python.

Processor time, the least of several starts, as multiples of `python -c pass` in the same run. Bytecode is
kept, as pip keeps it. In an editable installation bare Python itself takes longer, which flatters the
ratios: run it with the Python of an environment that labrun was installed into. Run:
python benchmarks/start.py
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

ONE_STEP = """labrun: 1
name: one
devices: {gantry: gantry@1}
steps:
  - {do: gantry.move_to, with: {x: 10 mm}, timeout: 2 min}
"""
AIMS = {"labrun --version": 6, "labrun check, one step": 16, "a device server": 25}
ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
LABRUN = (
    "import sys; from labrun.engine.cli import main; sys.argv = ['labrun', *sys.argv[1:]]; main()"
)


def run(*command: str) -> Callable[[], float]:
    """Start Python with these arguments, wait for its end, and return its processor time in seconds."""

    def measured() -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [sys.executable, *command], env=ENVIRONMENT, stdout=subprocess.DEVNULL, check=True
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    return measured


def serve(settings: Path) -> Callable[[], float]:
    """Start a device server, and return its processor time until it is ready."""

    def measured() -> float:
        command = [sys.executable, "-m", "labrun.drivers.server.serve", str(settings)]
        with subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.PIPE) as server:
            assert server.stdout is not None
            assert json.loads(server.stdout.readline())["ready"]
            taken = _processor_time(server.pid)
            server.terminate()
        return taken

    return measured


def _processor_time(pid: int) -> float:
    """Of a running process, from /proc (Linux)."""
    tasks = Path(f"/proc/{pid}/task").iterdir()
    return sum(int((task / "schedstat").read_text().split()[0]) for task in tasks) / 1e9


def server_settings(folder: Path) -> Path:
    """A server of one simulated gantry."""
    from labrun.schemas.contracts import shipped_contracts

    contract = shipped_contracts()["gantry@1"].model_dump(mode="json")
    device = {"contract": contract, "driver": "sim_gantry"}
    path = folder / "settings.json"
    path.write_text(json.dumps({"folder": str(folder / "server"), "devices": {"gantry": device}}))
    return path


def main() -> None:
    """Print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=9)
    times = parser.parse_args().times
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "one.yaml").write_text(ONE_STEP, encoding="utf-8")
        starts = {
            "python -c pass": run("-c", "pass"),
            "labrun --version": run("-c", LABRUN, "--version"),
            "labrun check, one step": run("-c", LABRUN, "check", str(folder / "one.yaml")),
        }
        if sys.platform == "linux":
            starts["a device server"] = serve(server_settings(folder))
        taken: dict[str, list[float]] = {name: [] for name in starts}
        for _ in range(times + 1):  # the first one writes the bytecode
            for name, start in starts.items():
                taken[name].append(start())
                time.sleep(0.02)
    bare = min(taken["python -c pass"][1:])
    print(f"{'':<24}{'ms':>8}{'ratio':>8}{'aim':>6}")
    for name, seconds in taken.items():
        least = min(seconds[1:])
        print(f"{name:<24}{least * 1e3:8.1f}{least / bare:8.1f}{AIMS.get(name, 1):6}")


if __name__ == "__main__":
    main()
