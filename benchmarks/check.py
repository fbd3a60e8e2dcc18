"""`labrun check`: its start, 1,000 lines and 20,000 steps, each beside yamllint on the same file.

yamllint (`pip install yamllint`) reads YAML and looks at its form; labrun reads it, checks every
step against the devices' contracts, computes its constants and holds them against limits. Where
yamllint is not installed its column is empty. Run: python benchmarks/check.py
"""

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

HEAD = """labrun: 1
name: large
params:
  z_safe: {type: quantity, unit: mm, default: 5 mm, minimum: 0 mm, maximum: 100 mm}
devices:
  gantry: gantry@1
  libs: libs_analyzer@1
defaults:
  timeout: 1 min
steps:
"""
FOUR_STEPS = """  - {{id: lift{n}, do: gantry.move_to, with: {{z: "${{{{ params.z_safe }}}}"}}}}

  - id: travel{n}
    do: gantry.move_to                    # to place {n}
    with:
      x: {x} mm
      y: ${{{{ params.z_safe + {y} mm }}}}
    retry: {{attempts: 3, wait: 1 s, on: [Timeout, Busy]}}
  - id: shoot{n}
    do: libs.measure
    on_unknown: probe

  - do: libs.export
    with:
      shot: ${{{{ steps.shoot{n}.shot_id }}}}
      file: spectra/place_{n}.csv
"""
TAIL = """finally:
  - {do: libs.disarm, on_error: continue}
"""
SMALL = HEAD + "  - {do: gantry.home, timeout: 2 min}\n"
WIDTH = 34


def large(steps: int) -> str:
    """A protocol of this many steps, of which every one is in order."""
    fours = (FOUR_STEPS.format(n=n, x=n % 400, y=n % 7) for n in range(steps // 4))
    return HEAD + "".join(fours) + TAIL


def median(measured: Callable[[], object], times: int) -> float:
    """Seconds, the median of several."""
    taken = []
    for _ in range(times):
        began = time.perf_counter()
        measured()
        taken.append(time.perf_counter() - began)
    return statistics.median(taken)


def process(*command: str) -> Callable[[], object]:
    """A command in a process of its own."""
    return lambda: subprocess.run(
        [sys.executable, "-m", *command], capture_output=True, check=False
    )


def lint(path: Path) -> Callable[[], object] | None:
    """yamllint on a file with its own default rules; None where it is not installed."""
    try:
        from yamllint import linter
        from yamllint.config import YamlLintConfig
    except ImportError:
        return None
    rules = YamlLintConfig("extends: default")
    return lambda: list(linter.run(path.read_text(encoding="utf-8"), rules))


def row(name: str, ours: float, theirs: float | None, most: float | None) -> None:
    """One line: seconds, the figure to keep under, and the ratio to yamllint."""
    beside = f"{theirs:9.3f} {ours / theirs:8.2f}" if theirs else f"{'-':>9} {'-':>8}"
    aim = f"{most:8.1f}" if most is not None else f"{'':>8}"
    print(f"  {name:<{WIDTH}}{ours:9.3f} {aim} {beside}")


def checks(folder: Path, steps: int, times: int, most: float) -> None:
    """A protocol read, and checked, after start-up."""
    from labrun.engine.check import check_file
    from labrun.engine.language.source import read_source

    path = folder / f"steps{steps}.yaml"
    path.write_text(large(steps), encoding="utf-8")
    lines = path.read_text(encoding="utf-8").count("\n")
    checked = check_file(path)
    assert checked.ok, [problem.message for problem in checked.problems[:3]]
    rules = lint(path)
    theirs = median(rules, times) if rules is not None else None
    print(f" {steps:,} steps, {lines:,} lines")
    row(
        "read, with the place of everything", median(lambda: read_source(path), times), theirs, None
    )
    row("checked", median(lambda: check_file(path), times), theirs, most)


def starts(folder: Path, times: int) -> None:
    """The command on a protocol of one step."""
    path = folder / "small.yaml"
    path.write_text(SMALL, encoding="utf-8")
    theirs = None
    if lint(path) is not None:
        theirs = median(process("yamllint", str(path)), times)
    print(" one step, from the command line")
    row(
        "labrun check FILE",
        median(process("labrun.engine", "check", str(path)), times),
        theirs,
        0.7,
    )
    row("  of it Python itself", median(process("this"), times), theirs, None)


def main() -> None:
    """Print them all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=5)
    parser.add_argument("--steps", type=int, default=20_000)
    said = parser.parse_args()
    print(f"  {'':<{WIDTH}}{'seconds':>9} {'at most':>8} {'yamllint':>9} {'ratio':>8}")
    with tempfile.TemporaryDirectory() as folder:
        starts(Path(folder), said.times)
        checks(Path(folder), 248, said.times, 0.3)
        checks(Path(folder), said.steps, 1, 10.0)
    if lint(Path(__file__)) is None:
        print("  yamllint is not installed: pip install yamllint")


if __name__ == "__main__":
    main()
